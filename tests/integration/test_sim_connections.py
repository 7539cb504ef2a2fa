"""Connections to the simulator over real sockets: reboots, clients that never read, clients that come and go."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator, Callable
from typing import Any

import pytest

from sim_bridge.autopilot.dialect import mavlink, new_codec
from sim_bridge.fleet import Fleet
from sim_bridge.server import Server
from sim_bridge.world import World
from tests.fakes.sim_missions import sim_plan

DEADLINE_S = 30.0


class TcpClient:
    """A ground station on a TCP connection."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader, self.writer = reader, writer
        self._voice, self._ears = new_codec(255, 190), new_codec(0)

    @classmethod
    async def open(cls, port: int) -> TcpClient:
        return cls(*await asyncio.open_connection("127.0.0.1", port))

    def send(self, message: Any) -> None:
        self.writer.write(message.pack(self._voice))
        self._voice.seq = (self._voice.seq + 1) % 256

    async def hear(self, wanted: Callable[[Any], bool]) -> Any:
        """The first message that is wanted; None when the vehicle closes the connection."""
        async with asyncio.timeout(DEADLINE_S):
            while data := await self.reader.read(4096):
                for message in self._ears.parse_buffer(data) or ():
                    if wanted(message):
                        return message
        return None

    def close(self) -> None:
        self.writer.close()


def of_kind(kind: str) -> Callable[[Any], bool]:
    return lambda message: bool(message.get_type() == kind)


@pytest.fixture
async def port(free_port_base: int) -> AsyncIterator[int]:
    """Port of one vehicle that runs ten times as fast as real ones."""
    plan = sim_plan(simulation={"ready_after_s": 300.0, "mavlink_port": free_port_base + 100})
    server = Server(Fleet(plan, World.of(plan)), 10.0)
    stop = asyncio.Event()
    await server.open()
    running = asyncio.create_task(server.run(stop))
    try:
        yield plan.mavlink_port(0)
    finally:
        stop.set()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(DEADLINE_S):
                await running
        await server.close()


def command(number: int, *parameters: float) -> Any:
    return mavlink.MAVLink_command_long_message(1, 1, number, 0, *parameters, *[0.0] * (7 - len(parameters)))


async def test_after_a_reboot_the_same_port_comes_back(port: int) -> None:
    client = await TcpClient.open(port)
    await client.hear(of_kind("HEARTBEAT"))
    client.send(command(246, 1))
    acknowledgement = await client.hear(of_kind("COMMAND_ACK"))
    assert (acknowledgement.command, acknowledgement.result) == (246, 0)
    assert await client.hear(lambda message: False) is None
    client.close()
    again = await TcpClient.open(port)
    again.send(command(512, 2))
    told = await again.hear(of_kind("SYSTEM_TIME"))
    assert told.time_unix_usec == 0
    again.close()


async def test_a_client_that_never_reads_does_not_delay_others(port: int) -> None:
    deaf = socket.create_connection(("127.0.0.1", port))
    deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    codec = new_codec(254, 190)
    deaf.sendall(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 50, 1).pack(codec))
    client = await TcpClient.open(port)
    try:
        for number in range(50):
            client.send(mavlink.MAVLink_timesync_message(0, number + 1))
            answer = await client.hear(of_kind("TIMESYNC"))
            assert answer.ts1 == number + 1
            deaf.sendall(mavlink.MAVLink_param_request_list_message(1, 1).pack(codec))
    finally:
        client.close()
        deaf.close()


async def test_clients_come_and_go(port: int) -> None:
    for _ in range(40):
        client = await TcpClient.open(port)
        assert await client.hear(of_kind("HEARTBEAT")) is not None
        client.close()
        await client.writer.wait_closed()
