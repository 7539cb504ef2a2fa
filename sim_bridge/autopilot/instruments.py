"""Raw instruments and the inside of the autopilot, as a simulated body has them: plausible, consistent, no more."""

from __future__ import annotations

import math

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import MessageBuilder, Service
from sim_bridge.autopilot.telemetry import degrees_e7

GRAVITY_MG = 1000
GRAVITY_M_S2 = 9.80665
SEA_LEVEL_HPA = 1013.25
PRESSURE_SCALE_M = 44_330.8
PRESSURE_EXPONENT = 5.25588
"""International standard atmosphere below 11 km."""
WATER_HPA_M = 100.0
"""Rise of pressure per metre of depth."""
TEMPERATURE_CDEG = 3_500
FIELD_MILLIGAUSS = (220.0, 0.0, 420.0)
"""Earth's magnetic field in NED, middle latitudes."""
STICKS = (1500, 1500, 1000, 1500, 1800, 1000, 1000, 1800)
"""Channels of a transmitter with centred sticks and no throttle."""
IDLE_PWM, WORKING_PWM = 1000, 1550


class InstrumentService(Service):
    """Builders of the messages that ground stations plot and scripts wait for."""

    def builders(self) -> dict[int, MessageBuilder]:
        power = mavlink.MAVLink_power_status_message(5000, 0, 0)
        memory = mavlink.MAVLink_meminfo_message(0, 65535, 131072)
        drift = mavlink.MAVLink_ahrs_message(0.0, 0.0, 0.0, 0.0, 0.0, 0.002, 0.002)
        return {
            mavlink.MAVLINK_MSG_ID_RAW_IMU: self.raw_imu,
            mavlink.MAVLINK_MSG_ID_SCALED_IMU2: lambda: mavlink.MAVLink_scaled_imu2_message(*self._scaled_imu()),
            mavlink.MAVLINK_MSG_ID_SCALED_IMU3: lambda: mavlink.MAVLink_scaled_imu3_message(*self._scaled_imu()),
            mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE: lambda: mavlink.MAVLink_scaled_pressure_message(*self._pressure()),
            mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE2: lambda: mavlink.MAVLink_scaled_pressure2_message(
                *self._pressure()
            ),
            mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: self.servo_outputs,
            mavlink.MAVLINK_MSG_ID_RC_CHANNELS: self.radio_channels,
            mavlink.MAVLINK_MSG_ID_RC_CHANNELS_SCALED: self.scaled_outputs,
            mavlink.MAVLINK_MSG_ID_POWER_STATUS: lambda: power,
            mavlink.MAVLINK_MSG_ID_MEMINFO: lambda: memory,
            mavlink.MAVLINK_MSG_ID_NAV_CONTROLLER_OUTPUT: self.navigation,
            mavlink.MAVLINK_MSG_ID_AHRS: lambda: drift,
            mavlink.MAVLINK_MSG_ID_AHRS2: self.second_estimate,
            mavlink.MAVLINK_MSG_ID_VIBRATION: self.vibration,
            mavlink.MAVLINK_MSG_ID_TERRAIN_REPORT: self.terrain_report,
            mavlink.MAVLINK_MSG_ID_SIMSTATE: self.simulation_state,
        }

    def _heading_rad(self) -> float:
        return math.radians((self.node.vehicle.heading_deg + 180.0) % 360.0 - 180.0)

    def _accelerations_mg(self) -> tuple[int, int, int]:
        """Gravity as the tilted body feels it, forward, right, down."""
        roll, pitch = self.node.vehicle.attitude_rad
        return (
            round(GRAVITY_MG * math.sin(pitch)),
            round(-GRAVITY_MG * math.sin(roll) * math.cos(pitch)),
            round(-GRAVITY_MG * math.cos(roll) * math.cos(pitch)),
        )

    def _field_milligauss(self) -> tuple[int, int, int]:
        north, _, down = FIELD_MILLIGAUSS
        heading = self._heading_rad()
        return (round(north * math.cos(heading)), round(-north * math.sin(heading)), round(down))

    def raw_imu(self) -> Message:
        return mavlink.MAVLink_raw_imu_message(
            self.node.time_boot_us, *self._accelerations_mg(), 0, 0, 0, *self._field_milligauss(), 0, TEMPERATURE_CDEG
        )

    def _scaled_imu(self) -> tuple[int, ...]:
        accelerations, field = self._accelerations_mg(), self._field_milligauss()
        return (self.node.time_boot_ms, *accelerations, 0, 0, 0, *field, TEMPERATURE_CDEG)

    def _pressure(self) -> tuple[float, ...]:
        up_m = self.node.vehicle.pilot.position_enu_m[2] + self.node.datum.altitude_amsl_m
        hectopascals = SEA_LEVEL_HPA * (1.0 - max(up_m, 0.0) / PRESSURE_SCALE_M) ** PRESSURE_EXPONENT
        return (self.node.time_boot_ms, hectopascals + WATER_HPA_M * max(-up_m, 0.0), 0.0, TEMPERATURE_CDEG, 0)

    def servo_outputs(self) -> Message:
        vehicle = self.node.vehicle
        pwm = 0
        if vehicle.armed:
            pwm = IDLE_PWM if vehicle.landed else WORKING_PWM
        outputs = [
            (pwm or IDLE_PWM) if vehicle.parameters.get(f"SERVO{number}_FUNCTION", 0.0) else 0 for number in range(1, 9)
        ]
        return mavlink.MAVLink_servo_output_raw_message(self.node.time_boot_us & 0xFFFFFFFF, 0, *outputs, *[0] * 8)

    def radio_channels(self) -> Message:
        silent = [0] * (18 - len(STICKS))
        return mavlink.MAVLink_rc_channels_message(self.node.time_boot_ms, 16, *STICKS, *silent, 255)

    def scaled_outputs(self) -> Message | None:
        """Rudder and throttle of rovers and boats."""
        vehicle = self.node.vehicle
        if vehicle.personality.mav_type not in (mavlink.MAV_TYPE_GROUND_ROVER, mavlink.MAV_TYPE_SURFACE_BOAT):
            return None
        speed = math.hypot(*vehicle.pilot.velocity_enu_m_s[:2])
        throttle = round(10_000 * min(speed / vehicle.settings.speed_m_s, 1.0)) if vehicle.armed else 0
        return mavlink.MAVLink_rc_channels_scaled_message(self.node.time_boot_ms, 0, 0, 0, throttle, 0, 0, 0, 0, 0, 0)

    def navigation(self) -> Message:
        vehicle = self.node.vehicle
        roll, pitch = (math.degrees(angle) for angle in vehicle.attitude_rad)
        bearing_deg, distance_m, higher_m = 0, 0, 0.0
        target = vehicle.pilot.target_enu_m
        if target is not None:
            here = vehicle.pilot.position_enu_m
            east, north = target[0] - here[0], target[1] - here[1]
            higher_m = target[2] - here[2]
            distance_m = min(round(math.hypot(east, north)), 65535)
            bearing_deg = round(math.degrees(math.atan2(east, north)))
        return mavlink.MAVLink_nav_controller_output_message(
            roll, pitch, bearing_deg, bearing_deg, distance_m, higher_m, 0.0, 0.0
        )

    def second_estimate(self) -> Message:
        place = self.node.believed_place()
        return mavlink.MAVLink_ahrs2_message(
            *self.node.vehicle.attitude_rad,
            self._heading_rad(),
            place.altitude_amsl_m,
            degrees_e7(place.latitude_deg),
            degrees_e7(place.longitude_deg),
        )

    def vibration(self) -> Message:
        return mavlink.MAVLink_vibration_message(self.node.time_boot_us, 0.002, 0.002, 0.002, 0, 0, 0)

    def terrain_report(self) -> Message | None:
        vehicle = self.node.vehicle
        if not vehicle.parameters.get("TERRAIN_ENABLE", 0.0):
            return None
        place = self.node.believed_place()
        east_m, north_m, up_m = vehicle.pilot.position_enu_m
        ground_m = vehicle.surface_m(east_m, north_m)
        return mavlink.MAVLink_terrain_report_message(
            degrees_e7(place.latitude_deg),
            degrees_e7(place.longitude_deg),
            round(vehicle.parameters.get("TERRAIN_SPACING", 100.0)),
            ground_m + self.node.datum.altitude_amsl_m,
            up_m - ground_m,
            0,
            504,
        )

    def simulation_state(self) -> Message:
        """The truth, as ArduPilot's own simulation tells it."""
        place = self.node.datum.to_geodetic(self.node.vehicle.true_position_enu_m)
        accelerations = (component * GRAVITY_M_S2 / GRAVITY_MG for component in self._accelerations_mg())
        return mavlink.MAVLink_simstate_message(
            *self.node.vehicle.attitude_rad,
            self._heading_rad(),
            *accelerations,
            0.0,
            0.0,
            0.0,
            degrees_e7(place.latitude_deg),
            degrees_e7(place.longitude_deg),
        )
