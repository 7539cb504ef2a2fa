"""How well the vehicle is: sensors, estimator, battery, and whether it stands or flies."""

from __future__ import annotations

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import CommandHandler, CommandRequest, MessageBuilder, Service
from sim_bridge.modes import LandedState
from sim_bridge.reply import Outcome

ALWAYS_WELL = (
    mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG
    | mavlink.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
    | mavlink.MAV_SYS_STATUS_SENSOR_ANGULAR_RATE_CONTROL
    | mavlink.MAV_SYS_STATUS_SENSOR_ATTITUDE_STABILIZATION
    | mavlink.MAV_SYS_STATUS_SENSOR_YAW_POSITION
    | mavlink.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS
    | mavlink.MAV_SYS_STATUS_AHRS
)
WITH_POSITION = (
    mavlink.MAV_SYS_STATUS_SENSOR_GPS
    | mavlink.MAV_SYS_STATUS_SENSOR_Z_ALTITUDE_CONTROL
    | mavlink.MAV_SYS_STATUS_SENSOR_XY_POSITION_CONTROL
)
_ESTIMATOR_WITH_POSITION = 831
_ESTIMATOR_WITHOUT = 1 << 7 | 1
"""Flags of EKF_STATUS_REPORT: everything but terrain, against attitude with constant position."""


class HealthService(Service):
    """Health, battery and landed state."""

    def builders(self) -> dict[int, MessageBuilder]:
        return {
            mavlink.MAVLINK_MSG_ID_SYS_STATUS: self.system_status,
            mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: self.battery_status,
            mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: self.extended_state,
            mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT: self.estimator_status,
        }

    def commands(self) -> dict[int, CommandHandler]:
        return {mavlink.MAV_CMD_RUN_PREARM_CHECKS: self._run_prearm_checks}

    def system_status(self) -> Message:
        vehicle = self.node.vehicle
        present = (
            ALWAYS_WELL | WITH_POSITION | mavlink.MAV_SYS_STATUS_SENSOR_BATTERY | mavlink.MAV_SYS_STATUS_PREARM_CHECK
        )
        healthy = ALWAYS_WELL
        if vehicle.position_known and not vehicle.fix_lost:
            healthy |= WITH_POSITION
        if vehicle.battery.remaining > 0.0:
            healthy |= mavlink.MAV_SYS_STATUS_SENSOR_BATTERY
        if vehicle.ready_to_arm:
            healthy |= mavlink.MAV_SYS_STATUS_PREARM_CHECK
        enabled = present
        if vehicle.flight_plan.fence or vehicle.settings.fence.action is not None:
            present |= mavlink.MAV_SYS_STATUS_GEOFENCE
        if vehicle.settings.fence.action is not None:
            enabled |= mavlink.MAV_SYS_STATUS_GEOFENCE
        if vehicle.fence_breach() is None:
            healthy |= mavlink.MAV_SYS_STATUS_GEOFENCE
        return mavlink.MAVLink_sys_status_message(
            present,
            enabled,
            healthy,
            100,
            round(vehicle.battery.voltage_v * 1000),
            _centiamperes(vehicle.battery.current_a),
            round(vehicle.battery.remaining * 100),
            *[0] * 6,
        )

    def battery_status(self) -> Message:
        battery = self.node.vehicle.battery
        capacity_mah = self.node.vehicle.settings.capacity_mah
        return mavlink.MAVLink_battery_status_message(
            0,
            mavlink.MAV_BATTERY_FUNCTION_UNKNOWN,
            mavlink.MAV_BATTERY_TYPE_LIPO,
            2500,
            [round(battery.voltage_v * 1000)] + [0xFFFF] * 9,
            _centiamperes(battery.current_a),
            round((1.0 - battery.remaining) * capacity_mah),
            -1,
            round(battery.remaining * 100),
            round(battery.remaining * battery.endurance_s),
        )

    def extended_state(self) -> Message:
        vehicle = self.node.vehicle
        state = vehicle.landed_state if vehicle.personality.reports_landed_state else LandedState.UNDEFINED
        return mavlink.MAVLink_extended_sys_state_message(mavlink.MAV_VTOL_STATE_UNDEFINED, int(state))

    def estimator_status(self) -> Message:
        known = self.node.vehicle.position_known
        flags = _ESTIMATOR_WITH_POSITION if known else _ESTIMATOR_WITHOUT
        return mavlink.MAVLink_ekf_status_report_message(flags, 0.01, 0.01, 0.01, 0.01, 0.0)

    def _run_prearm_checks(self, request: CommandRequest) -> Outcome:
        vehicle = self.node.vehicle
        if vehicle.armed:
            return Outcome.TEMPORARILY_REJECTED
        for problem in vehicle.prearm_problems(vehicle.mode):
            vehicle.say(2, vehicle.wording.not_ready.format(problem=problem))
        return Outcome.ACCEPTED


def _centiamperes(current_a: float) -> int:
    """Current as MAVLink's int16 holds it."""
    return min(round(current_a * 100), 32767)
