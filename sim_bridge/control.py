"""Orders to a running simulator, for drills: one line of text in, one line out, on a TCP port of its own.

The port is the one below the first MAVLink port. A line `VEHICLE FAULT on` or `VEHICLE FAULT off` is answered with
`ok`, or with a sentence that says what is wrong.
"""

from __future__ import annotations

import asyncio
import socket

from sim_bridge.faults import FAULTS
from sim_bridge.fleet import Fleet

DEFAULT_ENDPOINT = "127.0.0.1:5759"
MAX_LINE_BYTES = 200
ANSWER_WITHIN_S = 5.0


def control_port(fleet: Fleet) -> int:
    return fleet.plan.mission.simulation.mavlink_port - 1


class ControlPort:
    """Listens for drills."""

    def __init__(self, fleet: Fleet) -> None:
        self._fleet = fleet
        self._listener: asyncio.Server | None = None

    async def open(self, host: str, port: int) -> None:
        """Listen; OSError when the port cannot be had."""
        self._listener = await asyncio.start_server(self._serve, host, port, limit=MAX_LINE_BYTES)

    def close(self) -> None:
        if self._listener is not None:
            self._listener.close()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            line = await asyncio.wait_for(reader.readline(), ANSWER_WITHIN_S)
            writer.write((self.obey(line.decode("ascii", "replace")) + "\n").encode("ascii", "replace"))
            await writer.drain()
        except (ValueError, TimeoutError, ConnectionError):
            pass  # a peer that says too much, nothing, or goes away
        finally:
            writer.close()

    def obey(self, line: str) -> str:
        """Carry out one line and return the answer."""
        words = line.split()
        if len(words) != 3 or words[2] not in ("on", "off"):
            return "say VEHICLE FAULT on, or VEHICLE FAULT off"
        name, fault, state = words
        if name not in self._fleet.plan.vehicle_names:
            return f"there is no vehicle '{name}'; the mission has {', '.join(self._fleet.plan.vehicle_names)}"
        if fault not in FAULTS:
            return f"there is no fault '{fault}'; choose one of {', '.join(FAULTS)}"
        self._fleet.faults.set(self._fleet.plan.index_of(name), fault, state == "on")
        return "ok"


class InjectError(Exception):
    """An order that did not come through; its text is one sentence with the endpoint and the mend."""


def inject(endpoint: str, vehicle: str, fault: str, present: bool) -> None:
    """Begin or end a fault in the simulator at `host:port`; InjectError when that fails."""
    host, _, port = endpoint.rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 65_536:
        raise InjectError(f"{endpoint} is no endpoint; give one like {DEFAULT_ENDPOINT}")
    try:
        with socket.create_connection((host.strip("[]"), int(port)), ANSWER_WITHIN_S) as connection:
            connection.sendall(f"{vehicle} {fault} {'on' if present else 'off'}\n".encode("ascii", "replace"))
            answer = connection.makefile("r", encoding="ascii", errors="replace").readline().strip()
    except OSError as error:
        raise InjectError(
            f"no simulator answers at {endpoint} ({error.strerror or error}); "
            "start sim-bridge, or give --endpoint with the port below its first MAVLink port"
        ) from None
    if answer != "ok":
        raise InjectError(f"{endpoint}: {answer or 'no answer; is a simulator listening there?'}")
