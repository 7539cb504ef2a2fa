"""The mission protocol of a vehicle that holds no mission, fence or rally points: lists are empty, uploads refused."""

from __future__ import annotations

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, MessageBuilder, MessageHandler, Service

LISTS = (mavlink.MAV_MISSION_TYPE_MISSION, mavlink.MAV_MISSION_TYPE_FENCE, mavlink.MAV_MISSION_TYPE_RALLY)


class MissionService(Service):
    """Every reply echoes the mission type."""

    def handlers(self) -> dict[str, MessageHandler]:
        return {
            "MISSION_REQUEST_LIST": self._on_request_list,
            "MISSION_REQUEST_INT": self._refuse_item,
            "MISSION_REQUEST": self._refuse_item,
            "MISSION_ITEM_INT": self._refuse_item,
            "MISSION_COUNT": self._on_count,
            "MISSION_CLEAR_ALL": self._on_clear_all,
        }

    def builders(self) -> dict[int, MessageBuilder]:
        return {mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: self.mission_current}

    def mission_current(self) -> Message:
        return mavlink.MAVLink_mission_current_message(0, 0, mavlink.MISSION_STATE_NO_MISSION, 0)

    def _acknowledge(self, client: Client, message: Message, result: int) -> None:
        self.node.send(
            client,
            mavlink.MAVLink_mission_ack_message(
                message.get_srcSystem(), message.get_srcComponent(), result, message.mission_type
            ),
        )

    def _on_request_list(self, client: Client, message: Message) -> None:
        if message.mission_type not in LISTS:
            self._acknowledge(client, message, mavlink.MAV_MISSION_UNSUPPORTED)
            return
        self.node.send(
            client,
            mavlink.MAVLink_mission_count_message(
                message.get_srcSystem(), message.get_srcComponent(), 0, message.mission_type
            ),
        )

    def _refuse_item(self, client: Client, message: Message) -> None:
        self._acknowledge(client, message, mavlink.MAV_MISSION_ERROR)

    def _on_count(self, client: Client, message: Message) -> None:
        empty = message.count == 0 and message.mission_type in LISTS
        self._acknowledge(client, message, mavlink.MAV_MISSION_ACCEPTED if empty else mavlink.MAV_MISSION_UNSUPPORTED)

    def _on_clear_all(self, client: Client, message: Message) -> None:
        self._acknowledge(client, message, mavlink.MAV_MISSION_ACCEPTED)
