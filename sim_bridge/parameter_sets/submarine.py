"""ArduSub's own parameters; ranges stand at those that the simulated body obeys."""

from __future__ import annotations

from functools import cache

from sim_bridge.parameter_sets.common import common_rows
from sim_bridge.parameters import Parameter, parameter_rows

STREAM_RATES_HZ = (2, 2, 2, 2, 3, 10, 10, 3, 0)
THRUSTERS = (33, 34, 35, 36, 37, 38)

SUBMARINE = """
SURFACE_DEPTH    real  -10 -100 0
FORMAT_VERSION   int16 1
SYSID_THISMAV    int16 1 1 255
SYSID_MYGCS      int16 255 1 255
PILOT_THR_FILT   real  0
XTRACK_ANG_LIM   int16 45
WP_YAW_BEHAVIOR  int8  1
PILOT_SPEED_UP   int16 50 10 500
PILOT_SPEED_DN   int16 0 0 500
PILOT_ACCEL_Z    int16 100 10 500
THR_DZ           int16 100
SURFACE_MAX_THR  real  0.1
SURFACE_NOBARO_T real  10

# Failsafes and fence
FS_GCS_ENABLE    int8  0
FS_GCS_TIMEOUT   real  5 0.1 3600
FS_LEAK_ENABLE   int8  1
FS_PRESS_ENABLE  int8  0
FS_PRESS_MAX     int32 105000
FS_TEMP_ENABLE   int8  0
FS_TEMP_MAX      int8  62
FS_TERRAIN_ENAB  int8  1
FS_PILOT_INPUT   int8  0
FS_PILOT_TIMEOUT real  3
FS_CRASH_CHECK   int8  0
FS_EKF_ACTION    int8  0
FS_EKF_THRESH    real  0.8
BATT_FS_LOW_ACT  int8  0
BATT_FS_CRT_ACT  int8  3
FENCE_ENABLE     int8  0
FENCE_TYPE       int8  7
FENCE_ACTION     int8  1
FENCE_ALT_MAX    real  100 -1000 100000
FENCE_ALT_MIN    real  -10 -10000 1000
FENCE_RADIUS     real  300 1 1000000
FENCE_MARGIN     real  2 0 10000
LEAK1_PIN        int8  -1
LEAK1_LOGIC      int8  0
LEAK1_TYPE       int8  0

# Waypoints, guided flight, depth
WPNAV_SPEED      real  100 1 2000
WPNAV_RADIUS     real  200 5 10000
WPNAV_SPEED_UP   real  50 1 500
WPNAV_SPEED_DN   real  50 1 500
WPNAV_ACCEL      real  50 5 500
WPNAV_ACCEL_Z    real  50 5 500
WPNAV_RFND_USE   int8  1
GUID_TIMEOUT     real  3 0.1 60
CIRCLE_RADIUS    real  1000 0 200000
CIRCLE_RATE      real  20 -90 90
RNGFND_SQ_MIN    int8  90
SURFTRAK_DEPTH   real  -50 -10000 0
RNGFND_SURF_TGT  real  2

# Frame, lights, joystick
FRAME_CONFIG     int8  2
JS_GAIN_DEFAULT  real  0.5
JS_GAIN_MAX      real  1
JS_GAIN_MIN      real  0.25
JS_GAIN_STEPS    int8  4
JS_LIGHTS_STEPS  int8  8
JS_THR_GAIN      real  1
BTN0_FUNCTION    int16 0
BTN1_FUNCTION    int16 6
BTN2_FUNCTION    int16 8
BTN3_FUNCTION    int16 7
MOT_1_DIRECTION  int8  1
MOT_2_DIRECTION  int8  1
MOT_3_DIRECTION  int8  1
MOT_4_DIRECTION  int8  1
MOT_5_DIRECTION  int8  1
MOT_6_DIRECTION  int8  1
PSC_POSZ_P       real  3
PSC_VELZ_P       real  8
PSC_ACCZ_P       real  0.5
PSC_ACCZ_I       real  0.1
PSC_POSXY_P      real  1
PSC_VELXY_P      real  1
ATC_ANG_RLL_P    real  6
ATC_ANG_PIT_P    real  6
ATC_ANG_YAW_P    real  6
ATC_RAT_RLL_P    real  0.135
ATC_RAT_PIT_P    real  0.135
ATC_RAT_YAW_P    real  0.18
"""


@cache
def submarine_rows() -> tuple[Parameter, ...]:
    """The whole table of a simulated ArduSub."""
    return parameter_rows(SUBMARINE) + common_rows(STREAM_RATES_HZ, THRUSTERS)
