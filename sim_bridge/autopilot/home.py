"""Home and the estimator's origin."""

from __future__ import annotations

import math

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.guided import latitude_longitude_deg
from sim_bridge.autopilot.service import Client, CommandHandler, CommandRequest, MessageBuilder, MessageHandler, Service
from sim_bridge.autopilot.telemetry import degrees_e7
from sim_bridge.reply import Outcome
from vehicle_agent.domain.frames import Geodetic, enu_to_ned


class HomeService(Service):
    """Tells and sets where the vehicle returns to."""

    def commands(self) -> dict[int, CommandHandler]:
        return {
            mavlink.MAV_CMD_GET_HOME_POSITION: self._get_home,
            mavlink.MAV_CMD_DO_SET_HOME: self._set_home,
        }

    def handlers(self) -> dict[str, MessageHandler]:
        return {"SET_GPS_GLOBAL_ORIGIN": self._on_set_origin}

    def builders(self) -> dict[int, MessageBuilder]:
        return {
            mavlink.MAVLINK_MSG_ID_HOME_POSITION: self.home_position,
            mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: self.origin,
        }

    def home_position(self) -> Message | None:
        vehicle = self.node.vehicle
        home, origin = vehicle.home_enu_m, vehicle.origin_enu_m
        if home is None or origin is None:
            return None
        place = self.node.datum.to_geodetic(home)
        return mavlink.MAVLink_home_position_message(
            degrees_e7(place.latitude_deg),
            degrees_e7(place.longitude_deg),
            round(place.altitude_amsl_m * 1000),
            *enu_to_ned((home[0] - origin[0], home[1] - origin[1], home[2] - origin[2])),
            [math.nan] * 4,
            0.0,
            0.0,
            0.0,
            self.node.time_boot_us,
        )

    def origin(self) -> Message | None:
        origin = self.node.vehicle.origin_enu_m
        if origin is None:
            return None
        place = self.node.datum.to_geodetic(origin)
        return mavlink.MAVLink_gps_global_origin_message(
            degrees_e7(place.latitude_deg),
            degrees_e7(place.longitude_deg),
            round(place.altitude_amsl_m * 1000),
            self.node.time_boot_us,
        )

    def _on_set_origin(self, client: Client, message: Message) -> None:
        if message.target_system not in (0, self.node.system_id):
            return
        place = Geodetic(message.latitude * 1e-7, message.longitude * 1e-7, message.altitude * 1e-3)
        if abs(place.latitude_deg) > 90.0 or abs(place.longitude_deg) > 180.0:
            return
        reply = self.node.vehicle.set_origin(self.node.datum.to_enu(place))
        told = self.origin()
        if reply.accepted and told is not None:
            self.node.broadcast(told)

    def _get_home(self, request: CommandRequest) -> Outcome:
        message = self.home_position()
        if message is None:
            return Outcome.FAILED
        self.node.send(request.client, message)
        return Outcome.ACCEPTED

    def _set_home(self, request: CommandRequest) -> Outcome:
        vehicle = self.node.vehicle
        home = vehicle.pilot.position_enu_m
        if request.parameters[0] != 1:
            place = latitude_longitude_deg(request)
            if place is None:
                return Outcome.DENIED
            home = self.node.datum.to_enu(Geodetic(*place, request.z))
        outcome = vehicle.set_home(home).outcome
        message = self.home_position()
        if outcome is Outcome.ACCEPTED and message is not None:
            self.node.broadcast(message)
        return outcome
