"""ArduCopter's own parameters; ranges stand at those that the simulated body obeys."""

from __future__ import annotations

from functools import cache

from sim_bridge.parameter_sets.common import common_rows
from sim_bridge.parameters import Parameter, parameter_rows

STREAM_RATES_HZ = (0,) * 9
MOTORS = (33, 34, 35, 36)

COPTER = """
FORMAT_VERSION   int16 120
SYSID_THISMAV    int16 1 1 255
SYSID_MYGCS      int16 255 1 255
PILOT_THR_FILT   real  0
PILOT_TKOFF_ALT  real  0
PILOT_THR_BHV    int16 0
PILOT_SPEED_UP   int16 250
PILOT_SPEED_DN   int16 0
PILOT_ACCEL_Z    int16 250
PILOT_Y_RATE     real  202.5
PILOT_Y_EXPO     real  0
THR_DZ           int16 100

# Return to launch
RTL_ALT          int32 1500 0 1000000
RTL_CONE_SLOPE   real  3 0 100
RTL_SPEED        int16 0 0 10000
RTL_ALT_FINAL    int16 0 0 10000
RTL_CLIMB_MIN    int16 0 0 30000
RTL_LOIT_TIME    int32 5000 0 600000
RTL_ALT_TYPE     int8  0
RTL_OPTIONS      int32 0

# Failsafes and fence
FS_GCS_ENABLE    int8  0
FS_GCS_TIMEOUT   real  5 0.1 3600
FS_OPTIONS       int32 16
FS_THR_ENABLE    int8  0
FS_THR_VALUE     int16 975
FS_CRASH_CHECK   int8  1
FS_EKF_ACTION    int8  1
FS_EKF_THRESH    real  0.8
FS_VIBE_ENABLE   int8  1
FS_DR_ENABLE     int8  2
FS_DR_TIMEOUT    int16 30
BATT_FS_LOW_ACT  int8  2
BATT_FS_CRT_ACT  int8  1
FENCE_ENABLE     int8  0
FENCE_TYPE       int8  7
FENCE_ACTION     int8  1
FENCE_ALT_MAX    real  100 1 100000
FENCE_ALT_MIN    real  -10
FENCE_RADIUS     real  300 1 1000000
FENCE_MARGIN     real  2 0 10000

# Take-off, landing, arming
DISARM_DELAY     int8  10 0 127
TKOFF_SLEW_TIME  real  2
LAND_SPEED       int16 50 10 1000
LAND_SPEED_HIGH  int16 0 0 5000
LAND_ALT_LOW     int16 1000 0 30000
LAND_REPOSITION  int8  1
AUTO_OPTIONS     int32 0

# Waypoints, guided flight, loiter
WPNAV_SPEED      real  1000 1 10000
WPNAV_RADIUS     real  200 5 10000
WPNAV_SPEED_UP   real  250 1 5000
WPNAV_SPEED_DN   real  150 1 5000
WPNAV_ACCEL      real  250 10 2000
WPNAV_ACCEL_Z    real  100 10 2000
WPNAV_ACCEL_C    real  0
WPNAV_JERK       real  1 0.1 100
WPNAV_RFND_USE   int8  1
WPNAV_TER_MARGIN real  10
WP_YAW_BEHAVIOR  int8  2
WP_NAVALT_MIN    real  0
GUID_TIMEOUT     real  3 0.1 60
GUID_OPTIONS     int32 0
LOIT_SPEED       real  1250
LOIT_ACC_MAX     real  500
LOIT_BRK_ACCEL   real  250
LOIT_BRK_DELAY   real  1
LOIT_BRK_JERK    real  500
LOIT_ANG_MAX     real  0
CIRCLE_RADIUS    real  1000 0 200000
CIRCLE_RATE      real  20 -90 90
CIRCLE_OPTIONS   int16 1

# Flight modes and their switch
FLTMODE1         int8  7
FLTMODE2         int8  9
FLTMODE3         int8  6
FLTMODE4         int8  3
FLTMODE5         int8  5
FLTMODE6         int8  0
FLTMODE_CH       int8  5
INITIAL_MODE     int8  0
SIMPLE           int8  0
SUPER_SIMPLE     int8  0

# Frame and motors
FRAME_CLASS      int8  1
FRAME_TYPE       int8  1
MOT_YAW_HEADROOM int16 200
MOT_THST_EXPO    real  0.65
MOT_SPIN_MAX     real  0.95
MOT_SPIN_MIN     real  0.15
MOT_SPIN_ARM     real  0.1
MOT_BAT_VOLT_MAX real  12.8
MOT_BAT_VOLT_MIN real  9.6
MOT_BAT_CURR_MAX real  0
MOT_PWM_TYPE     int8  0
MOT_PWM_MIN      int16 1000
MOT_PWM_MAX      int16 2000
MOT_SPOOL_TIME   real  0.5
MOT_THST_HOVER   real  0.39
MOT_HOVER_LEARN  int8  2
MOT_SAFE_DISARM  int8  0
MOT_SAFE_TIME    real  1

# Controllers
ATC_ANG_RLL_P    real  4.5
ATC_ANG_PIT_P    real  4.5
ATC_ANG_YAW_P    real  4.5
ATC_ACCEL_R_MAX  real  110000
ATC_ACCEL_P_MAX  real  110000
ATC_ACCEL_Y_MAX  real  27000
ATC_RATE_R_MAX   real  0
ATC_RATE_P_MAX   real  0
ATC_RATE_Y_MAX   real  0
ATC_SLEW_YAW     real  6000
ATC_INPUT_TC     real  0.15
ATC_ANG_LIM_TC   real  1
ATC_RAT_RLL_P    real  0.135
ATC_RAT_RLL_I    real  0.135
ATC_RAT_RLL_D    real  0.0036
ATC_RAT_RLL_IMAX real  0.5
ATC_RAT_PIT_P    real  0.135
ATC_RAT_PIT_I    real  0.135
ATC_RAT_PIT_D    real  0.0036
ATC_RAT_PIT_IMAX real  0.5
ATC_RAT_YAW_P    real  0.18
ATC_RAT_YAW_I    real  0.018
ATC_RAT_YAW_D    real  0
ATC_RAT_YAW_IMAX real  0.5
PSC_POSXY_P      real  1
PSC_VELXY_P      real  2
PSC_VELXY_I      real  1
PSC_VELXY_D      real  0.5
PSC_POSZ_P       real  1
PSC_VELZ_P       real  5
PSC_ACCZ_P       real  0.5
PSC_ACCZ_I       real  1
PSC_ACCZ_D       real  0
PSC_JERK_XY      real  5
PSC_JERK_Z       real  5
PSC_ANGLE_MAX    real  0
ANGLE_MAX        int16 3000
PHLD_BRAKE_RATE  int16 8
PHLD_BRAKE_ANGLE int16 3000
GCS_PID_MASK     int16 0
DEV_OPTIONS      int32 0
ACRO_BAL_ROLL    real  1
ACRO_BAL_PITCH   real  1
ACRO_TRAINER     int8  2
ACRO_RP_RATE     real  360
ACRO_Y_RATE      real  202.5
"""


@cache
def copter_rows() -> tuple[Parameter, ...]:
    """The table of an ArduCopter."""
    return parameter_rows(COPTER) + common_rows(STREAM_RATES_HZ, MOTORS)
