"""Where the vehicle is and how it moves."""

from __future__ import annotations

import math

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import MessageBuilder, Service
from vehicle_agent.domain.frames import Geodetic, Point, enu_to_ned

_ONLY_POSITION = 0x0DF8
"""type_mask of a target that is a position."""


def degrees_e7(degrees: float) -> int:
    return round(degrees * 1e7)


class TelemetryService(Service):
    """Position, velocity, attitude and the present target."""

    def builders(self) -> dict[int, MessageBuilder]:
        return {
            mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: self.global_position,
            mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: self.local_position,
            mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: self.gps_raw,
            mavlink.MAVLINK_MSG_ID_ATTITUDE: self.attitude,
            mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: self.attitude_quaternion,
            mavlink.MAVLINK_MSG_ID_VFR_HUD: self.vfr_hud,
            mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT: self.position_target,
        }

    def _geodetic(self) -> Geodetic:
        """Where it believes to be; latitude and longitude are 0 before it knows."""
        vehicle = self.node.vehicle
        place = self.node.datum.to_geodetic(vehicle.pilot.position_enu_m)
        return place if vehicle.origin_enu_m is not None else Geodetic(0.0, 0.0, place.altitude_amsl_m)

    def _velocity_ned_m_s(self) -> Point:
        return enu_to_ned(self.node.vehicle.pilot.velocity_enu_m_s)

    def global_position(self) -> Message:
        vehicle, place = self.node.vehicle, self._geodetic()
        north, east, down = (round(component * 100) for component in self._velocity_ned_m_s())
        home = vehicle.home_enu_m
        above_home_m = vehicle.pilot.position_enu_m[2] - home[2] if home else 0.0
        return mavlink.MAVLink_global_position_int_message(
            self.node.time_boot_ms,
            degrees_e7(place.latitude_deg),
            degrees_e7(place.longitude_deg),
            round(place.altitude_amsl_m * 1000),
            round(above_home_m * 1000),
            north,
            east,
            down,
            round(vehicle.heading_deg * 100) % 36000,
        )

    def local_position(self) -> Message | None:
        """Relative to the estimator's origin, which is where the vehicle first knew its position."""
        vehicle = self.node.vehicle
        if vehicle.origin_enu_m is None:
            return None
        here, origin = vehicle.pilot.position_enu_m, vehicle.origin_enu_m
        offset = (here[0] - origin[0], here[1] - origin[1], here[2] - origin[2])
        return mavlink.MAVLink_local_position_ned_message(
            self.node.time_boot_ms, *enu_to_ned(offset), *self._velocity_ned_m_s()
        )

    def gps_raw(self) -> Message:
        place = self._geodetic()
        north, east, _ = self._velocity_ned_m_s()
        fixed = self.node.vehicle.has_fix
        fix = mavlink.GPS_FIX_TYPE_DGPS if fixed else mavlink.GPS_FIX_TYPE_NO_FIX
        return mavlink.MAVLink_gps_raw_int_message(
            self.node.time_boot_us,
            fix,
            degrees_e7(place.latitude_deg),
            degrees_e7(place.longitude_deg),
            round(place.altitude_amsl_m * 1000),
            121,
            200,
            round(math.hypot(north, east) * 100),
            round(math.degrees(math.atan2(east, north)) % 360.0 * 100) % 36000,
            10 if fixed else 0,
        )

    def attitude(self) -> Message:
        yaw = math.radians((self.node.vehicle.heading_deg + 180.0) % 360.0 - 180.0)
        return mavlink.MAVLink_attitude_message(
            self.node.time_boot_ms, *self.node.vehicle.attitude_rad, yaw, 0.0, 0.0, 0.0
        )

    def attitude_quaternion(self) -> Message:
        roll, pitch = (angle / 2.0 for angle in self.node.vehicle.attitude_rad)
        yaw = math.radians(self.node.vehicle.heading_deg) / 2.0
        cos_roll, sin_roll, cos_pitch, sin_pitch = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
        cos_yaw, sin_yaw = math.cos(yaw), math.sin(yaw)
        return mavlink.MAVLink_attitude_quaternion_message(
            self.node.time_boot_ms,
            cos_roll * cos_pitch * cos_yaw + sin_roll * sin_pitch * sin_yaw,
            sin_roll * cos_pitch * cos_yaw - cos_roll * sin_pitch * sin_yaw,
            cos_roll * sin_pitch * cos_yaw + sin_roll * cos_pitch * sin_yaw,
            cos_roll * cos_pitch * sin_yaw - sin_roll * sin_pitch * cos_yaw,
            0.0,
            0.0,
            0.0,
        )

    def vfr_hud(self) -> Message:
        vehicle = self.node.vehicle
        north, east, down = self._velocity_ned_m_s()
        speed = math.hypot(north, east)
        throttle = 0 if vehicle.landed else 39
        return mavlink.MAVLink_vfr_hud_message(
            speed, speed, round(vehicle.heading_deg) % 360, throttle, self._geodetic().altitude_amsl_m, -down
        )

    def position_target(self) -> Message | None:
        target = self.node.vehicle.pilot.target_enu_m
        if target is None:
            return None
        place = self.node.datum.to_geodetic(target)
        return mavlink.MAVLink_position_target_global_int_message(
            self.node.time_boot_ms,
            mavlink.MAV_FRAME_GLOBAL,
            _ONLY_POSITION,
            degrees_e7(place.latitude_deg),
            degrees_e7(place.longitude_deg),
            place.altitude_amsl_m,
            *[0.0] * 8,
        )
