"""The mission protocol: mission, fence and rally points go up and down by the same rules, told apart by mission_type.

Every reply echoes the mission type. An upload counts as a whole or not at all: when an item is refused, the list that
was there stays.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.item_rules import MOST_ITEMS, Refusal, check_item
from sim_bridge.autopilot.item_upload import Due, Upload
from sim_bridge.autopilot.service import Client, MessageHandler, Service
from sim_bridge.autopilot.telemetry import degrees_e7
from sim_bridge.flight_plan import FRAME_GLOBAL, MissionCommand, PlanItem
from sim_bridge.reply import StatusText

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

MISSION, FENCE, RALLY, ALL = (
    mavlink.MAV_MISSION_TYPE_MISSION,
    mavlink.MAV_MISSION_TYPE_FENCE,
    mavlink.MAV_MISSION_TYPE_RALLY,
    mavlink.MAV_MISSION_TYPE_ALL,
)
NAMES = {MISSION: "Mission", FENCE: "Fence", RALLY: "Rally"}
RECEIVED = {MISSION: "Flight plan received", FENCE: "Fence received", RALLY: "Rally points received"}


class MissionService(Service):
    """One list each of mission items, fence items and rally points; one upload at a time of each."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._uploads: dict[int, Upload] = {}

    def handlers(self) -> dict[str, MessageHandler]:
        return {
            "MISSION_REQUEST_LIST": self._on_request_list,
            "MISSION_REQUEST_INT": self._on_request_int,
            "MISSION_REQUEST": self._on_request,
            "MISSION_COUNT": self._on_count,
            "MISSION_WRITE_PARTIAL_LIST": self._on_write_partial,
            "MISSION_ITEM_INT": self._on_item_int,
            "MISSION_ITEM": self._on_item,
            "MISSION_CLEAR_ALL": self._on_clear_all,
            "MISSION_ACK": self._on_ack,
        }

    def forget(self, client: Client) -> None:
        for mission_type in [number for number, upload in self._uploads.items() if upload.client is client]:
            del self._uploads[mission_type]

    def tick(self) -> None:
        now_us = self.node.vehicle.clock.elapsed_us
        for mission_type, upload in list(self._uploads.items()):
            due = upload.due(now_us)
            if due is Due.ASK:
                self._ask(mission_type, upload)
            elif due is Due.GIVE_UP:
                del self._uploads[mission_type]
                self._answer(upload.client, upload, mavlink.MAV_MISSION_OPERATION_CANCELLED, mission_type)
                self._tell(upload.client, 4, f"{NAMES[mission_type]} upload timeout")

    # Answers

    def _acknowledge(self, client: Client, message: Message, result: int, reason: str = "") -> None:
        if result != mavlink.MAV_MISSION_ACCEPTED:
            what = f"{message.get_type()} of mission type {message.mission_type}"
            self.node.log(f"{what} refused with result {result}" + (f": {reason}" if reason else ""))
        acknowledgement = mavlink.MAVLink_mission_ack_message(
            message.get_srcSystem(), message.get_srcComponent(), result, message.mission_type
        )
        self.node.send(client, acknowledgement)

    def _answer(self, client: Client, upload: Upload, result: int, mission_type: int) -> None:
        self.node.send(
            client,
            mavlink.MAVLink_mission_ack_message(upload.system_id, upload.component_id, result, mission_type),
        )

    def _tell(self, client: Client, severity: int, text: str) -> None:
        self.node.send_text(client, StatusText(severity, text))

    def _ask(self, mission_type: int, upload: Upload) -> None:
        self.node.send(
            upload.client,
            mavlink.MAVLink_mission_request_message(upload.system_id, upload.component_id, upload.wanted, mission_type),
        )

    def _items(self, mission_type: int) -> tuple[PlanItem, ...]:
        plan = self.node.vehicle.flight_plan
        return {MISSION: plan.mission, FENCE: plan.fence, RALLY: plan.rally}[mission_type]

    def _may_read(self, client: Client, message: Message) -> bool:
        if message.mission_type not in NAMES:
            self._acknowledge(client, message, mavlink.MAV_MISSION_UNSUPPORTED)
        elif message.mission_type in self._uploads:
            self._acknowledge(client, message, mavlink.MAV_MISSION_DENIED, "an upload is under way")
        else:
            return True
        return False

    # Downloads

    def _on_request_list(self, client: Client, message: Message) -> None:
        if self._may_read(client, message):
            count = mavlink.MAVLink_mission_count_message(
                message.get_srcSystem(),
                message.get_srcComponent(),
                len(self._items(message.mission_type)),
                message.mission_type,
            )
            self.node.send(client, count)

    def _requested(self, client: Client, message: Message) -> PlanItem | None:
        if not self._may_read(client, message):
            return None
        items = self._items(message.mission_type)
        index = int(message.seq)
        if index >= len(items):
            self._acknowledge(client, message, mavlink.MAV_MISSION_ERROR, f"there is no item {message.seq}")
            return None
        if index == 0 and message.mission_type == MISSION:
            return self._home()
        return items[index]

    def _home(self) -> PlanItem:
        home = self.node.vehicle.home_enu_m
        nowhere = (0.0, 0.0, 0.0, 0.0)
        if home is None:
            return PlanItem(MissionCommand.WAYPOINT, FRAME_GLOBAL, nowhere, 0, 0, 0.0)
        place = self.node.datum.to_geodetic(home)
        latitude, longitude = degrees_e7(place.latitude_deg), degrees_e7(place.longitude_deg)
        return PlanItem(MissionCommand.WAYPOINT, FRAME_GLOBAL, nowhere, latitude, longitude, place.altitude_amsl_m)

    def _is_current(self, message: Message) -> bool:
        return bool(message.mission_type == MISSION and message.seq == self.node.vehicle.auto_flight.current)

    def _on_request_int(self, client: Client, message: Message) -> None:
        item = self._requested(client, message)
        if item is not None:
            told = mavlink.MAVLink_mission_item_int_message(
                message.get_srcSystem(), message.get_srcComponent(), message.seq, item.frame, item.command,
                int(self._is_current(message)), 1, *item.parameters, item.x, item.y, item.z, message.mission_type,
            )  # fmt: skip
            self.node.send(client, told)

    def _on_request(self, client: Client, message: Message) -> None:
        item = self._requested(client, message)
        if item is not None:
            told = mavlink.MAVLink_mission_item_message(
                message.get_srcSystem(), message.get_srcComponent(), message.seq, item.frame, item.command,
                int(self._is_current(message)), 1, *item.parameters, item.x * 1e-7, item.y * 1e-7, item.z,
                message.mission_type,
            )  # fmt: skip
            self.node.send(client, told)

    def _on_ack(self, client: Client, message: Message) -> None:
        """A client ends its download, or breaks its upload off."""
        upload = self._uploads.get(message.mission_type)
        refused = message.type != mavlink.MAV_MISSION_ACCEPTED
        if upload is not None and refused and upload.is_from(message.get_srcSystem(), message.get_srcComponent()):
            del self._uploads[message.mission_type]

    # Uploads

    def _on_count(self, client: Client, message: Message) -> None:
        if message.mission_type not in NAMES:
            self._acknowledge(client, message, mavlink.MAV_MISSION_UNSUPPORTED)
        elif message.count > MOST_ITEMS[message.mission_type]:
            most = MOST_ITEMS[message.mission_type]
            self._acknowledge(client, message, mavlink.MAV_MISSION_NO_SPACE, f"at most {most} items")
        elif self._may_begin(client, message):
            self._begin(client, message, 0, message.count - 1, ())

    def _on_write_partial(self, client: Client, message: Message) -> None:
        if message.mission_type not in NAMES:
            self._acknowledge(client, message, mavlink.MAV_MISSION_UNSUPPORTED)
            return
        first, last, count = message.start_index, message.end_index, len(self._items(message.mission_type))
        if not 0 <= first <= last < count:
            self._tell(client, 4, "Flight plan update rejected")
            self._acknowledge(client, message, mavlink.MAV_MISSION_ERROR, f"there are no items {first} to {last}")
        elif self._may_begin(client, message):
            self._begin(client, message, first, last, self._items(message.mission_type))

    def _may_begin(self, client: Client, message: Message) -> bool:
        """Whoever uploads may begin anew; others wait."""
        upload = self._uploads.get(message.mission_type)
        if upload is None or upload.is_from(message.get_srcSystem(), message.get_srcComponent()):
            return True
        self._acknowledge(client, message, mavlink.MAV_MISSION_DENIED, "an upload is under way")
        return False

    def _begin(self, client: Client, message: Message, first: int, last: int, old: tuple[PlanItem, ...]) -> None:
        upload = Upload(
            client, message.get_srcSystem(), message.get_srcComponent(), first, last,
            self.node.vehicle.clock.elapsed_us, list(old[:first]), old[last + 1 :],
        )  # fmt: skip
        self._uploads[message.mission_type] = upload
        if upload.complete:
            self._finish(client, message, upload)
        else:
            self._ask(message.mission_type, upload)

    def _on_item_int(self, client: Client, message: Message) -> None:
        self._take(client, message, message.x, message.y)

    def _on_item(self, client: Client, message: Message) -> None:
        def whole(value: float) -> int:
            return round(value * 1e7) if abs(value) < 200.0 else 2_000_000_000

        self._take(client, message, whole(message.x), whole(message.y))

    def _take(self, client: Client, message: Message, x: int, y: int) -> None:
        upload = self._uploads.get(message.mission_type)
        if upload is None:
            self._acknowledge(client, message, mavlink.MAV_MISSION_ERROR, "nobody asked for it")
            return
        if message.seq != upload.wanted:
            self._acknowledge(
                client, message, mavlink.MAV_MISSION_INVALID_SEQUENCE, f"item {upload.wanted} was asked for"
            )
            return
        if not upload.is_from(message.get_srcSystem(), message.get_srcComponent()):
            self._acknowledge(client, message, mavlink.MAV_MISSION_DENIED, "another system uploads")
            return
        parameters = (message.param1, message.param2, message.param3, message.param4)
        item = check_item(
            message.mission_type, message.command, message.frame, parameters, x, y, message.z,
        )  # fmt: skip
        if isinstance(item, Refusal):
            del self._uploads[message.mission_type]
            self._acknowledge(client, message, item.result, f"item {message.seq}: {item.reason}")
            return
        upload.take(item, self.node.vehicle.clock.elapsed_us)
        if upload.complete:
            self._finish(client, message, upload)
        else:
            self._ask(message.mission_type, upload)

    def _finish(self, client: Client, message: Message, upload: Upload) -> None:
        mission_type = message.mission_type
        del self._uploads[mission_type]
        problem = self._store(mission_type, (*upload.items, *upload.tail))
        if problem is not None:
            self._acknowledge(client, message, mavlink.MAV_MISSION_ERROR, problem)
            return
        self._acknowledge(client, message, mavlink.MAV_MISSION_ACCEPTED)
        if message.get_type() != "MISSION_CLEAR_ALL":
            self._tell(client, 6, RECEIVED[mission_type])

    def _store(self, mission_type: int, items: tuple[PlanItem, ...]) -> str | None:
        """Replace a list; returns what is wrong when it cannot."""
        vehicle = self.node.vehicle
        if mission_type == MISSION:
            vehicle.flight_plan.mission = items
            vehicle.auto_flight.mission_replaced()
            vehicle.set_parameter("MIS_TOTAL", len(items))
        elif mission_type == FENCE:
            try:
                vehicle.flight_plan.set_fence(items)
            except ValueError as error:
                return str(error)
            vehicle.set_parameter("FENCE_TOTAL", len(items))
        else:
            vehicle.flight_plan.rally = items
            vehicle.set_parameter("RALLY_TOTAL", len(items))
        return None

    def _on_clear_all(self, client: Client, message: Message) -> None:
        wanted = tuple(NAMES) if message.mission_type == ALL else (message.mission_type,)
        if not set(wanted) <= set(NAMES):
            self._acknowledge(client, message, mavlink.MAV_MISSION_UNSUPPORTED)
        elif any(mission_type in self._uploads for mission_type in wanted):
            self._acknowledge(client, message, mavlink.MAV_MISSION_DENIED, "an upload is under way")
        elif MISSION in wanted and self.node.vehicle.auto_flight.running:
            self._acknowledge(client, message, mavlink.MAV_MISSION_ERROR, "the mission is being flown")
        else:
            for mission_type in wanted:
                self._store(mission_type, ())
            self._acknowledge(client, message, mavlink.MAV_MISSION_ACCEPTED)
