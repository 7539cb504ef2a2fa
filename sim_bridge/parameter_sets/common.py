"""Parameters that every ArduPilot firmware has, with its defaults."""

from __future__ import annotations

from functools import cache

from sim_bridge.parameters import Parameter, parameter_rows

CHANNELS = 16

STREAMS = """
SR{port}_RAW_SENS int16 {rates[0]} 0 50
SR{port}_EXT_STAT int16 {rates[1]} 0 50
SR{port}_RC_CHAN  int16 {rates[2]} 0 50
SR{port}_RAW_CTRL int16 {rates[3]} 0 50
SR{port}_POSITION int16 {rates[4]} 0 50
SR{port}_EXTRA1   int16 {rates[5]} 0 50
SR{port}_EXTRA2   int16 {rates[6]} 0 50
SR{port}_EXTRA3   int16 {rates[7]} 0 50
SR{port}_PARAMS   int16 {rates[8]} 0 50
SR{port}_ADSB     int16 0 0 50
"""

RADIO_CHANNEL = """
RC{channel}_MIN      int16 1100
RC{channel}_TRIM     int16 1500
RC{channel}_MAX      int16 1900
RC{channel}_REVERSED int8  0
RC{channel}_DZ       int16 30
RC{channel}_OPTION   int16 0
"""

SERVO_CHANNEL = """
SERVO{channel}_MIN      int16 1100
SERVO{channel}_MAX      int16 1900
SERVO{channel}_TRIM     int16 1500
SERVO{channel}_REVERSED int8  0
SERVO{channel}_FUNCTION int16 {function}
"""

COMMON = """
# Serial ports, logging, scheduling
SERIAL0_BAUD     int32 115
SERIAL0_PROTOCOL int8  2
SERIAL1_PROTOCOL int8  2
SERIAL1_BAUD     int32 57
SERIAL3_PROTOCOL int8  5
SERIAL3_BAUD     int32 230
LOG_BACKEND_TYPE int8  1
LOG_BITMASK      int32 176126
LOG_FILE_BUFSIZE int16 200
LOG_DISARMED     int8  0
LOG_REPLAY       int8  0
LOG_FILE_DSRMROT int8  0
LOG_MAV_BUFSIZE  int8  8
LOG_FILE_TIMEOUT int16 5
LOG_FILE_MB_FREE int16 500
SCHED_DEBUG      int8  0
SCHED_LOOP_RATE  int16 400
SCHED_OPTIONS    int8  0
BRD_RTC_TYPES    int8  1
BRD_RTC_TZ_MIN   int16 0
BRD_SERIAL_NUM   int16 0
BRD_OPTIONS      int32 0
BRD_BOOT_DELAY   int16 0
STAT_BOOTCNT     int16 1
STAT_FLTTIME     int32 0
STAT_RUNTIME     int32 0
STAT_RESET       int32 1

# Arming
ARMING_CHECK     int32 1
ARMING_REQUIRE   int8  1
ARMING_ACCTHRESH real  0.75
ARMING_RUDDER    int8  2
ARMING_MIS_ITEMS int32 0
ARMING_OPTIONS   int32 0

# Attitude and estimator
AHRS_GPS_GAIN    real  1
AHRS_GPS_USE     int8  1
AHRS_YAW_P       real  0.2
AHRS_RP_P        real  0.2
AHRS_WIND_MAX    int8  0
AHRS_TRIM_X      real  0
AHRS_TRIM_Y      real  0
AHRS_TRIM_Z      real  0
AHRS_ORIENTATION int8  0
AHRS_EKF_TYPE    int8  3
AHRS_OPTIONS     int16 0
EK2_ENABLE       int8  0
EK3_ENABLE       int8  1
EK3_VELNE_M_NSE  real  0.3
EK3_VELD_M_NSE   real  0.5
EK3_VEL_I_GATE   int16 500
EK3_POSNE_M_NSE  real  0.5
EK3_POS_I_GATE   int16 500
EK3_GLITCH_RAD   int8  25
EK3_ALT_M_NSE    real  2
EK3_HGT_I_GATE   int16 500
EK3_MAG_M_NSE    real  0.05
EK3_MAG_CAL      int8  3
EK3_MAG_I_GATE   int16 300
EK3_GYRO_P_NSE   real  0.015
EK3_ACC_P_NSE    real  0.35
EK3_GBIAS_P_NSE  real  0.001
EK3_ABIAS_P_NSE  real  0.02
EK3_IMU_MASK     int8  3
EK3_CHECK_SCALE  int16 100
EK3_NOAID_M_NSE  real  10
EK3_RNG_USE_HGT  int8  -1
EK3_TERR_GRAD    real  0.1
EK3_SRC1_POSXY   int8  3
EK3_SRC1_VELXY   int8  3
EK3_SRC1_POSZ    int8  1
EK3_SRC1_VELZ    int8  3
EK3_SRC1_YAW     int8  1
EK3_SRC_OPTIONS  int16 1

# Inertial sensors, compass, barometer, satellite navigation
INS_GYR_CAL      int8  1
INS_GYRO_FILTER  int16 20
INS_ACCEL_FILTER int16 20
INS_USE          int8  1
INS_USE2         int8  1
INS_USE3         int8  1
INS_ENABLE_MASK  int8  127
INS_FAST_SAMPLE  int8  7
INS_ACCOFFS_X    real  0.001
INS_ACCOFFS_Y    real  0.001
INS_ACCOFFS_Z    real  0.001
INS_ACCSCAL_X    real  1.001
INS_ACCSCAL_Y    real  1.001
INS_ACCSCAL_Z    real  1.001
INS_GYROFFS_X    real  0
INS_GYROFFS_Y    real  0
INS_GYROFFS_Z    real  0
COMPASS_ENABLE   int8  1
COMPASS_OFS_X    real  5
COMPASS_OFS_Y    real  13
COMPASS_OFS_Z    real  -18
COMPASS_DEC      real  0
COMPASS_LEARN    int8  0
COMPASS_USE      int8  1
COMPASS_USE2     int8  1
COMPASS_USE3     int8  1
COMPASS_AUTODEC  int8  1
COMPASS_MOTCT    int8  0
COMPASS_ORIENT   int8  0
COMPASS_EXTERNAL int8  1
COMPASS_OFFS_MAX int16 1800
BARO_PRIMARY     int8  0
BARO_ALT_OFFSET  real  0
BARO_GND_TEMP    real  0
BARO1_GND_PRESS  real  94502
BARO2_GND_PRESS  real  94502
GPS_TYPE         int8  1
GPS_TYPE2        int8  0
GPS_NAVFILTER    int8  8
GPS_AUTO_SWITCH  int8  1
GPS_MIN_DGPS     int8  100
GPS_SBAS_MODE    int8  2
GPS_MIN_ELEV     int8  -100
GPS_GNSS_MODE    int8  0
GPS_RATE_MS      int16 200
GPS_POS1_X       real  0
GPS_POS1_Y       real  0
GPS_POS1_Z       real  0
GPS_HDOP_GOOD    int16 140

# Battery
BATT_MONITOR     int8  4
BATT_VOLT_PIN    int8  13
BATT_CURR_PIN    int8  12
BATT_VOLT_MULT   real  10.1
BATT_AMP_PERVLT  real  17
BATT_AMP_OFFSET  real  0
BATT_CAPACITY    int32 5000 1 1e9
BATT_SERIAL_NUM  int32 -1
BATT_LOW_TIMER   int8  10
BATT_FS_VOLTSRC  int8  0
BATT_LOW_VOLT    real  0
BATT_LOW_MAH     real  500
BATT_CRT_VOLT    real  0
BATT_CRT_MAH     real  200
BATT_ARM_VOLT    real  0
BATT_ARM_MAH     int32 0
BATT_OPTIONS     int32 0
BATT2_MONITOR    int8  0

# Fence, rally points, mission
FENCE_TOTAL      int8  0
FENCE_AUTOENABLE int8  0
FENCE_OPTIONS    int16 1
RALLY_TOTAL      int16 0
RALLY_INCL_HOME  int8  1
MIS_TOTAL        int16 0
MIS_RESTART      int8  0
MIS_OPTIONS      int16 0

# Range finders, obstacle avoidance, terrain
RNGFND1_TYPE     int8  0
RNGFND1_MIN_CM   int16 20
RNGFND1_MAX_CM   int16 700
RNGFND1_ORIENT   int8  25
RNGFND1_GNDCLEAR int8  10
PRX1_TYPE        int8  0
PRX_LOG_RAW      int8  0
AVOID_MARGIN     real  2
TERRAIN_ENABLE   int8  1
TERRAIN_SPACING  int16 100
TERRAIN_OPTIONS  int16 0

# Simulated body
SIM_SPEEDUP      real  1
SIM_RATE_HZ      int16 1200
SIM_WIND_SPD     real  0
SIM_WIND_DIR     real  180
SIM_WIND_TURB    real  0
SIM_BATT_VOLTAGE real  12.6
SIM_GPS_DISABLE  int8  0
SIM_GPS_NUMSATS  int8  10
"""


@cache
def common_rows(stream_rates_hz: tuple[int, ...], servo_functions: tuple[int, ...]) -> tuple[Parameter, ...]:
    """Rows after those of a firmware itself.

    `stream_rates_hz`: the nine SR0_ rates, from RAW_SENS to PARAMS. `servo_functions`: what drives which output.
    """
    functions = servo_functions + (0,) * (CHANNELS - len(servo_functions))
    text = STREAMS.format(port=0, rates=stream_rates_hz) + COMMON
    text += "".join(RADIO_CHANNEL.format(channel=number + 1) for number in range(CHANNELS))
    text += "".join(SERVO_CHANNEL.format(channel=number + 1, function=functions[number]) for number in range(CHANNELS))
    return parameter_rows(text)
