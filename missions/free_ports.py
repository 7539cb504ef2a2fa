"""Are the ports of a mission free? Asked before anything starts, so that the answer is a sentence and not a timeout."""

from __future__ import annotations

import errno
import socket

from missions.processes import is_simulated, simulated_names
from vehicle_agent.mission.load import MissionError, MissionPlan


def check_ports(plan: MissionPlan) -> None:
    """Raise MissionError naming the port, whose it is, and the key to change, when one cannot be listened on."""
    host = plan.mission.radio.endpoint_host
    zenoh_port = plan.mission.radio.zenoh_port
    wanted = [("tcp", zenoh_port + 1 + index, f"agent of '{name}'", "radio.zenoh_port") for index, name in _team(plan)]
    if simulated_names(plan):
        wanted.append(("tcp", zenoh_port, "simulator", "radio.zenoh_port"))
    for index, name in _team(plan):
        if is_simulated(plan, index):
            port = plan.mavlink_port(index)
            wanted += [(kind, port, f"autopilot of '{name}'", "simulation.mavlink_port") for kind in ("tcp", "udp")]
    for kind, port, owner, key in wanted:
        _check(plan, kind, host, port, owner, key)


def _team(plan: MissionPlan) -> list[tuple[int, str]]:
    return list(enumerate(plan.vehicle_names))


def _check(plan: MissionPlan, kind: str, host: str, port: int, owner: str, key: str) -> None:
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, proto=socket.IPPROTO_TCP)[0]
        with socket.socket(family, socket.SOCK_STREAM if kind == "tcp" else socket.SOCK_DGRAM) as probe:
            if kind == "tcp":  # ports of connections just closed do not count as in use
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
            if kind == "tcp":
                probe.listen(1)
    except (OSError, OverflowError) as error:
        if isinstance(error, OSError) and error.errno == errno.EADDRINUSE:
            raise MissionError(
                f"{plan.source}: {key}: {kind.upper()} port {port} on {host} (for the {owner}) is in use; "
                f"stop what uses it, change {key}, or choose other ports with --port-base"
            ) from None
        raise MissionError(
            f"{plan.source}: radio.endpoint_host: cannot listen on {host} {kind.upper()} port {port} ({error}); "
            "give an address of this machine and a port that you may use"
        ) from None
