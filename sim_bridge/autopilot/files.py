"""The files that a vehicle shows through MAVLink FTP: made when they are opened, kept nowhere."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import TYPE_CHECKING

from sim_bridge.autopilot.param_pack import packed_parameters
from sim_bridge.flight_plan import PlanItem

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

MISSION_FILES = {"mission.dat": 0, "fence.dat": 1, "rally.dat": 2}
"""Names to MAV_MISSION_TYPE."""
MISSION_MAGIC = 0x763D
_ITEM = struct.Struct("<4fiifHHBBBBBB")
"""MISSION_ITEM_INT as it lies in memory."""


def directory(node: Node, path: str) -> list[str] | None:
    """Entries of a directory as the protocol tells them, `Dname` or `Fname<tab>size`; None when there is none."""
    name = path.strip("/")
    if name == "":
        return ["D@MISSION", "D@PARAM", "D@SYS"]
    files = {"@PARAM": ("param.pck",), "@SYS": ("tasks.txt", "uarts.txt"), "@MISSION": tuple(MISSION_FILES)}.get(name)
    if files is None:
        return None
    return [f"F{file}\t{len(content(node, f'{name}/{file}') or b'')}" for file in files]


def content(node: Node, path: str) -> bytes | None:
    """Content of a file; None when there is none."""
    path, _, query = path.lstrip("/").partition("?")
    arguments = dict(part.partition("=")[::2] for part in query.split("&"))
    if path == "@PARAM/param.pck":
        return packed_parameters(
            node.vehicle.parameters,
            _number(arguments, "withdefaults", 0) == 1,
            _number(arguments, "start", 0),
            _number(arguments, "count", 0xFFFF),
        )
    if path == "@SYS/uarts.txt":
        return "".join(f"client {number}\n" for number in range(len(node.clients))).encode("ascii")
    if path == "@SYS/tasks.txt":
        return "".join(f"{type(service).__name__}\n" for service in node.services).encode("ascii")
    folder, _, name = path.partition("/")
    if folder == "@MISSION" and name in MISSION_FILES:
        mission_type = MISSION_FILES[name]
        plan = node.vehicle.flight_plan
        return _mission_file((plan.mission, plan.fence, plan.rally)[mission_type], mission_type)
    return None


def _number(arguments: dict[str, str], name: str, default: int) -> int:
    text = arguments.get(name, "")
    return int(text) if text.isascii() and text.isdigit() and len(text) < 6 else default


def _mission_file(items: Sequence[PlanItem], mission_type: int) -> bytes:
    head = struct.pack("<HHHHH", MISSION_MAGIC, mission_type, 0, 0, len(items))
    return head + b"".join(
        _ITEM.pack(*item.parameters, item.x, item.y, item.z, index, item.command, 0, 0, item.frame, 0, 1, mission_type)
        for index, item in enumerate(items)
    )
