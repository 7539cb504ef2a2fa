"""Distances: a beam downwards (DISTANCE_SENSOR, RANGEFINDER, WATER_DEPTH) and obstacles around (OBSTACLE_DISTANCE)."""

from __future__ import annotations

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import MessageBuilder, Service
from sim_bridge.autopilot.telemetry import degrees_e7

NOTHING_NEAR_CM = 65_535
SECTORS = 72
FARTHEST_OBSTACLE_M = 100.0


class RangingService(Service):
    """Says nothing until RNGFND1_TYPE or PRX1_TYPE tells that there is such a sensor, as ArduPilot.

    A single beam in the mission file sets RNGFND1_TYPE from the start.
    """

    def builders(self) -> dict[int, MessageBuilder]:
        return {
            mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR: self.distance_sensor,
            mavlink.MAVLINK_MSG_ID_RANGEFINDER: self.rangefinder,
            mavlink.MAVLINK_MSG_ID_WATER_DEPTH: self.water_depth,
            mavlink.MAVLINK_MSG_ID_OBSTACLE_DISTANCE: self.obstacle_distance,
        }

    def _limits_cm(self) -> tuple[int, int]:
        parameters = self.node.vehicle.parameters
        return (int(parameters.get("RNGFND1_MIN_CM", 20.0)), int(parameters.get("RNGFND1_MAX_CM", 700.0)))

    def _range_cm(self) -> int | None:
        """What the beam measures: beyond its reach a little more than that; None without a beam."""
        vehicle = self.node.vehicle
        if not vehicle.parameters.get("RNGFND1_TYPE", 0.0):
            return None
        return round(max(0.0, min(vehicle.range_down_m() * 100.0, self._limits_cm()[1] + 1.0)))

    def distance_sensor(self) -> Message | None:
        distance_cm = self._range_cm()
        if distance_cm is None:
            return None
        return mavlink.MAVLink_distance_sensor_message(
            self.node.time_boot_ms,
            *self._limits_cm(),
            distance_cm,
            mavlink.MAV_DISTANCE_SENSOR_UNKNOWN,
            0,
            mavlink.MAV_SENSOR_ROTATION_PITCH_270,
            0,
        )

    def rangefinder(self) -> Message | None:
        distance_cm = self._range_cm()
        return None if distance_cm is None else mavlink.MAVLink_rangefinder_message(distance_cm / 100.0, 0.0)

    def water_depth(self) -> Message | None:
        """Only boats tell it."""
        vehicle, distance_cm = self.node.vehicle, self._range_cm()
        if distance_cm is None or vehicle.personality.mav_type != mavlink.MAV_TYPE_SURFACE_BOAT:
            return None
        place = self.node.believed_place()
        roll, pitch = vehicle.attitude_rad
        return mavlink.MAVLink_water_depth_message(
            self.node.time_boot_ms, 0, int(distance_cm <= self._limits_cm()[1]), degrees_e7(place.latitude_deg),
            degrees_e7(place.longitude_deg), place.altitude_amsl_m, roll, pitch, 0.0, distance_cm / 100.0, 20.0,
        )  # fmt: skip

    def obstacle_distance(self) -> Message | None:
        vehicle = self.node.vehicle
        if not vehicle.parameters.get("PRX1_TYPE", 0.0):
            return None
        distances = vehicle.obstacle_distances_m(SECTORS, FARTHEST_OBSTACLE_M)
        told = [round(metres * 100.0) if metres < FARTHEST_OBSTACLE_M else NOTHING_NEAR_CM for metres in distances]
        return mavlink.MAVLink_obstacle_distance_message(
            self.node.time_boot_us, mavlink.MAV_DISTANCE_SENSOR_LASER, told, 0, 20, round(FARTHEST_OBSTACLE_M * 100.0),
            360.0 / SECTORS, 0.0, mavlink.MAV_FRAME_BODY_FRD,
        )  # fmt: skip
