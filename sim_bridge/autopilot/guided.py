"""Targets of guided flight: DO_REPOSITION, DO_PAUSE_CONTINUE and the SET_POSITION_TARGET messages."""

from __future__ import annotations

import math

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, CommandHandler, CommandRequest, MessageHandler, Service
from sim_bridge.modes import Behaviour
from sim_bridge.reply import Outcome
from vehicle_agent.domain.frames import Geodetic, Point, ned_to_enu

ABOVE_SEA_FRAMES = (mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_FRAME_GLOBAL_INT)
ABOVE_HOME_FRAMES = (mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
BODY_FRAMES = (mavlink.MAV_FRAME_BODY_NED, mavlink.MAV_FRAME_BODY_OFFSET_NED)
"""Forward, right and down; places count from the vehicle in both."""
LOCAL_FRAMES = (mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_LOCAL_OFFSET_NED, *BODY_FRAMES)
_IGNORES_POSITION = 0b111
_IGNORES_VELOCITY = 0b111 << 3


def latitude_longitude_deg(request: CommandRequest) -> tuple[float, float] | None:
    """Place of a command in degrees; None when it is none (ArduPilot also takes 0, 0 for none)."""
    scale = 1.0 if request.frame is None else 1e-7
    latitude_deg, longitude_deg = request.x * scale, request.y * scale
    if not (abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0) or (latitude_deg == longitude_deg == 0.0):
        return None
    return (latitude_deg, longitude_deg)


class GuidedService(Service):
    """Takes targets for guided flight."""

    def handlers(self) -> dict[str, MessageHandler]:
        return {
            "SET_POSITION_TARGET_GLOBAL_INT": self._on_global_target,
            "SET_POSITION_TARGET_LOCAL_NED": self._on_local_target,
        }

    def commands(self) -> dict[int, CommandHandler]:
        return {
            mavlink.MAV_CMD_DO_REPOSITION: self._reposition,
            mavlink.MAV_CMD_DO_PAUSE_CONTINUE: self._pause_continue,
        }

    def _target_enu_m(self, latitude_deg: float, longitude_deg: float, altitude_m: float, frame: int) -> Point | None:
        """Place in the mission's frame; None for a frame without support or an altitude that is none."""
        home = self.node.vehicle.home_enu_m
        if home is None or not math.isfinite(altitude_m):
            return None
        east_m, north_m, up_m = self.node.datum.to_enu(Geodetic(latitude_deg, longitude_deg, altitude_m))
        if frame in ABOVE_SEA_FRAMES:
            return (east_m, north_m, up_m)
        if frame in ABOVE_HOME_FRAMES:
            return (east_m, north_m, home[2] + altitude_m)
        return None

    def _reposition(self, request: CommandRequest) -> Outcome:
        vehicle = self.node.vehicle
        may_change_mode = request.parameters[1] == mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
        guided = vehicle.personality.guided_behaviour
        if request.frame is None or (vehicle.behaviour is not guided and not may_change_mode):
            return Outcome.DENIED
        place = latitude_longitude_deg(request)
        target = self._target_enu_m(*place, request.z, request.frame) if place else None
        if target is None:
            return Outcome.DENIED
        if not vehicle.enter(guided).accepted:
            return Outcome.FAILED
        return vehicle.set_destination(target).outcome

    def _pause_continue(self, request: CommandRequest) -> Outcome:
        vehicle = self.node.vehicle
        if vehicle.behaviour is not Behaviour.GUIDED or not vehicle.armed or vehicle.landed:
            return Outcome.FAILED
        if request.parameters[0] == 0:
            vehicle.pilot.taking_off = False
            vehicle.pilot.stop()
        return Outcome.ACCEPTED

    def _on_global_target(self, client: Client, message: Message) -> None:
        target = None
        if not message.type_mask & _IGNORES_POSITION:
            target = self._target_enu_m(
                message.lat_int * 1e-7, message.lon_int * 1e-7, message.alt, message.coordinate_frame
            )
            if target is None:
                return
        self._fly(target, message)

    def _on_local_target(self, client: Client, message: Message) -> None:
        vehicle, frame = self.node.vehicle, message.coordinate_frame
        if vehicle.origin_enu_m is None or frame not in LOCAL_FRAMES:
            return
        heading_deg = vehicle.heading_deg if frame in BODY_FRAMES else 0.0
        target = None
        if not message.type_mask & _IGNORES_POSITION:
            offset = _turned((message.x, message.y, message.z), heading_deg)
            start = vehicle.origin_enu_m if frame == mavlink.MAV_FRAME_LOCAL_NED else vehicle.pilot.position_enu_m
            target = (start[0] + offset[0], start[1] + offset[1], start[2] + offset[2])
        self._fly(target, message, heading_deg)

    def _fly(self, target_enu_m: Point | None, message: Message, heading_deg: float = 0.0) -> None:
        """Follow a target as ArduPilot does: only in guided flight, position before velocity, silently."""
        vehicle = self.node.vehicle
        if vehicle.behaviour is not Behaviour.GUIDED:
            # PX4 enters its offboard mode only while targets flow.
            vehicle.note_target()
            return
        if target_enu_m is not None:
            vehicle.set_destination(target_enu_m)
        elif not message.type_mask & _IGNORES_VELOCITY:
            vehicle.set_velocity(_turned((message.vx, message.vy, message.vz), heading_deg))


def _turned(forward_right_down: Point, heading_deg: float) -> Point:
    """A vector in ENU that is given along a heading, to its right, and downwards."""
    forward, right, down = forward_right_down
    along, across = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
    return ned_to_enu((forward * along - right * across, forward * across + right * along, down))
