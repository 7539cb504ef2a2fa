"""PX4's parameters for a multicopter; ranges stand at those that the simulated body obeys."""

from __future__ import annotations

from functools import cache

from sim_bridge.parameters import Parameter, parameter_rows

PX4 = """
BAT1_CAPACITY    real  5000 1 1e9
BAT1_N_CELLS     int32 6
BAT1_V_CHARGED   real  4.2
BAT1_V_EMPTY     real  3.5
BAT_CRIT_THR     real  0.07 0 1
BAT_EMERGEN_THR  real  0.05 0 1
BAT_LOW_THR      real  0.15 0 1
CAL_ACC0_ID      int32 1310988
CAL_GYRO0_ID     int32 1310988
CAL_MAG0_ID      int32 197388
CBRK_IO_SAFETY   int32 22027
CBRK_SUPPLY_CHK  int32 894281
COM_ARM_WO_GPS   int32 1
COM_DISARM_LAND  real  2 0 60
COM_DISARM_PRFLT real  10 -1 60
COM_DL_LOSS_T    int32 10 1 3600
COM_FLTMODE1     int32 -1
COM_LOW_BAT_ACT  int32 0 0 3
COM_OBL_RC_ACT   int32 0 0 7
COM_OF_LOSS_T    real  1 0.1 60
COM_POS_FS_DELAY int32 1
COM_RC_IN_MODE   int32 1
COM_RC_LOSS_T    real  0.5
EKF2_AID_MASK    int32 1
EKF2_GPS_CTRL    int32 7
EKF2_HGT_REF     int32 1
GF_ACTION        int32 2 0 5
GF_MAX_HOR_DIST  real  0 0 1000000
GF_MAX_VER_DIST  real  0 0 100000
IMU_INTEG_RATE   int32 200
MAV_COMP_ID      int32 1 1 250
MAV_PROTO_VER    int32 0
MAV_SYS_ID       int32 1 1 250
MAV_TYPE         int32 2
MC_PITCH_P       real  6.5
MC_ROLL_P        real  6.5
MC_YAW_P         real  2.8
MIS_DIST_1WP     real  900
MIS_TAKEOFF_ALT  real  2.5 0 10000
MIS_TKO_LAND_REQ int32 0
MPC_ACC_DOWN_MAX real  3 0.5 15
MPC_ACC_HOR      real  3 0.5 15
MPC_ACC_HOR_MAX  real  5
MPC_ACC_UP_MAX   real  4 0.5 15
MPC_JERK_AUTO    real  4
MPC_LAND_ALT1    real  10 0 122
MPC_LAND_ALT2    real  5
MPC_LAND_SPEED   real  0.7 0.1 10
MPC_MANTHR_MIN   real  0.08
MPC_THR_HOVER    real  0.5
MPC_TKO_SPEED    real  1.5
MPC_XY_CRUISE    real  5 0.1 100
MPC_XY_VEL_MAX   real  12
MPC_Z_VEL_MAX_DN real  1.5 0.1 50
MPC_Z_VEL_MAX_UP real  3 0.1 50
MPC_Z_V_AUTO_DN  real  1.5 0.1 50
MPC_Z_V_AUTO_UP  real  3 0.1 50
NAV_ACC_RAD      real  2 0.05 200
NAV_DLL_ACT      int32 0 0 6
NAV_RCL_ACT      int32 2
RTL_CONE_ANG     int32 45 0 90
RTL_DESCEND_ALT  real  30
RTL_LAND_DELAY   real  0 -1 3600
RTL_RETURN_ALT   real  60 0 10000
RTL_TYPE         int32 0
SDLOG_MODE       int32 0
SYS_AUTOSTART    int32 10016
SYS_FAILURE_EN   int32 0
SYS_HAS_BARO     int32 1
SYS_HAS_GPS      int32 1
SYS_HAS_MAG      int32 1
"""


@cache
def px4_rows() -> tuple[Parameter, ...]:
    """The whole table of a simulated PX4; in the order of names, as PX4 keeps it."""
    return parameter_rows(PX4)
