"""Forwards messages between the clients of a vehicle by the rules that ArduPilot documents for its routing.

A heartbeat goes to every other client except those on which its sender (system and component) has itself been heard.
Other messages go to other clients when they are for everybody, or for a system or component heard there. So a client
hears a second program that speaks with its own system id from another component; with the same component as well it
hears everything of that program but its heartbeats. Messages unknown to the dialect cannot be checked and are dropped.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import COMPONENT_ID, Message
from sim_bridge.autopilot.service import Client

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

MAX_ROUTES = 64


def route(node: Node, client: Client, message: Message) -> bool:
    """Forward a message where it belongs and tell whether the vehicle itself has to look at it."""
    sender = (message.get_srcSystem(), message.get_srcComponent())
    if sender == (node.system_id, COMPONENT_ID):
        return True
    if sender[0] != 0 and len(client.routes) < MAX_ROUTES:
        client.routes.add(sender)
    kind = message.get_type()
    if kind.startswith("UNKNOWN"):
        return False
    if kind in ("RADIO", "RADIO_STATUS", "ADSB_VEHICLE"):
        return True
    others = [other for other in node.clients if other is not client and other.routes]
    if kind == "HEARTBEAT":
        for other in node.clients:
            if other is not client and sender not in other.routes:
                _resend(other, message)
        return True
    target_system = int(getattr(message, "target_system", 0))
    target_component = int(getattr(message, "target_component", 0))
    for_us = target_system in (0, node.system_id)
    if target_system == node.system_id and target_component == COMPONENT_ID:
        return True
    forwarded = False
    for other in others:
        if target_system == 0 or any(
            target_system == system and (target_component in (0, component) or not for_us)
            for system, component in other.routes
        ):
            _resend(other, message)
            forwarded = True
    return for_us and (target_system == 0 or target_component in (0, COMPONENT_ID) or not forwarded)


def _resend(client: Client, message: Message) -> None:
    """Forwarded frames keep their bytes: sender, sequence number and signature."""
    client.outbox.append(bytes(message.get_msgbuf()))
