"""Message signing: SETUP_SIGNING gives the key; from then on frames without its signature are dropped."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, MessageHandler, Service
from sim_bridge.reply import StatusText

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

UNSIGNED = frozenset({mavlink.MAVLINK_MSG_ID_RADIO, mavlink.MAVLINK_MSG_ID_RADIO_STATUS})
"""Radios cannot sign what they report; nothing is commanded by these."""


class SigningService(Service):
    """Keeps the key of the node's connections. A key of zeros switches signing off."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self.node.signing.allow_unsigned_callback = _may_be_unsigned

    def handlers(self) -> dict[str, MessageHandler]:
        return {"SETUP_SIGNING": self._on_setup}

    def _on_setup(self, client: Client, message: Message) -> None:
        if message.target_system != self.node.system_id:
            return
        if self.node.vehicle.armed:
            self.node.send_text(client, StatusText(4, "ERROR: Won't setup signing when armed"))
            return
        signing = self.node.signing
        key = bytes(message.secret_key)
        if not any(key):
            signing.secret_key, signing.sign_outgoing = None, False
            return
        signing.secret_key, signing.sign_outgoing = key, True
        signing.timestamp = max(signing.timestamp, message.initial_timestamp)


def _may_be_unsigned(codec: Any, message_id: int) -> bool:
    return message_id in UNSIGNED
