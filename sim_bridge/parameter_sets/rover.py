"""ArduRover's own parameters, for a boat; ranges stand at those that the simulated body obeys."""

from __future__ import annotations

from functools import cache

from sim_bridge.parameter_sets.common import common_rows
from sim_bridge.parameters import Parameter, parameter_rows

STREAM_RATES_HZ = (1, 1, 1, 1, 1, 1, 1, 1, 10)
RUDDER_AND_THROTTLE = (26, 0, 70)

ROVER = """
FORMAT_VERSION   int16 16
SYSID_THISMAV    int16 1 1 255
SYSID_MYGCS      int16 255 1 255
INITIAL_MODE     int8  0
LOG_BITMASK_EXT  int32 0

# Speeds, turns, arrival
CRUISE_SPEED     real  2 0.1 100
CRUISE_THROTTLE  int8  50
WP_SPEED         real  2 0 100
WP_RADIUS        real  2 0.1 100
WP_ACCEL         real  0 0 100
WP_JERK          real  0
WP_OVERSHOOT     real  2
WP_PIVOT_ANGLE   int16 60
WP_PIVOT_RATE    int16 60
RTL_SPEED        real  0 0 100
LOIT_RADIUS      real  2 0 100
LOIT_TYPE        int8  0
LOIT_SPEED_GAIN  real  0.5
TURN_RADIUS      real  5 0 1000
ATC_STR_RAT_MAX  real  120
ATC_STR_RAT_FF   real  0.2
ATC_STR_RAT_P    real  0.2
ATC_STR_RAT_I    real  0.2
ATC_STR_RAT_D    real  0
ATC_STR_ANG_P    real  2
ATC_STR_ACC_MAX  real  120
ATC_SPEED_P      real  0.2
ATC_SPEED_I      real  0.2
ATC_SPEED_D      real  0
ATC_ACCEL_MAX    real  1 0.05 20
ATC_DECEL_MAX    real  0
ATC_BRAKE        int8  1
ATC_STOP_SPEED   real  0.1
ATC_TURN_MAX_G   real  0.6
GUID_OPTIONS     int32 0
GUID_TIMEOUT     real  3 0.1 60
MODE_CH          int8  8
MODE1            int8  0
MODE2            int8  0
MODE3            int8  0
MODE4            int8  0
MODE5            int8  0
MODE6            int8  0

# Failsafes and fence
FS_ACTION        int8  2
FS_TIMEOUT       real  1.5 0.1 3600
FS_THR_ENABLE    int8  1
FS_THR_VALUE     int16 910
FS_GCS_ENABLE    int8  0
FS_GCS_TIMEOUT   real  5 0.1 3600
FS_CRASH_CHECK   int8  0
FS_EKF_ACTION    int8  1
FS_EKF_THRESH    real  0.8
FS_OPTIONS       int32 0
FS_DR_ENABLE     int8  2
BATT_FS_LOW_ACT  int8  1
BATT_FS_CRT_ACT  int8  2
FENCE_ENABLE     int8  0
FENCE_TYPE       int8  6
FENCE_ACTION     int8  1
FENCE_RADIUS     real  300 1 1000000
FENCE_MARGIN     real  2 0 10000

# Hull, motors, sail
FRAME_CLASS      int8  2
FRAME_TYPE       int8  0
MOT_PWM_TYPE     int8  0
MOT_SAFE_DISARM  int8  0
MOT_THR_MIN      int8  0
MOT_THR_MAX      int8  100
MOT_SLEWRATE     int16 100
MOT_THST_EXPO    real  0
MOT_VEC_ANGLEMAX real  0
SAIL_ENABLE      int8  0
STICK_MIXING     int8  0
SPEED_MAX        real  0
PILOT_STEER_TYPE int8  0
BAL_PITCH_MAX    real  10
CRASH_ANGLE      int8  0
"""


@cache
def rover_rows() -> tuple[Parameter, ...]:
    """The whole table of a simulated ArduRover."""
    return parameter_rows(ROVER) + common_rows(STREAM_RATES_HZ, RUDDER_AND_THROTTLE)
