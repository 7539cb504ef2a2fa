"""Serves the fleet's autopilots on UDP and TCP and lets simulated time run at a multiple of real time."""

from __future__ import annotations

import asyncio
import errno
import time
from collections.abc import Callable
from typing import Any

from sim_bridge.autopilot.node import Node
from sim_bridge.autopilot.service import Client
from sim_bridge.fleet import STEP_US, Fleet
from sim_bridge.pacing import Pacer

BUFFER_LIMIT_BYTES = 65_536
"""A client that does not read loses messages beyond this backlog; nobody else waits for it."""
MAX_CLIENTS = 16
UDP_SILENCE_S = 10.0
"""A UDP peer that has said nothing for this long is gone."""
HEARTBEAT_WALL_S = 1.0
"""Clients count a vehicle's silence in real time, so a slow simulation adds heartbeats."""
SHORTEST_NAP_S = 0.008
"""Steps that are due meanwhile run together: waking up costs more than a step of a small fleet."""


class ServerError(Exception):
    """A server that cannot be opened; its text is one sentence with the endpoint and the mend."""


class TcpConnection(asyncio.Protocol):
    """One TCP client of one vehicle."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._client: Client | None = None
        self._transport: asyncio.Transport | None = None
        self.last_heard_s = 0.0

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        if len(self._node.clients) >= MAX_CLIENTS:
            transport.abort()
            return
        self._client = self._node.connect()
        self._client.wake = self.flush
        self._client.hang_up = transport.close

    def data_received(self, data: bytes) -> None:
        if self._client is not None and not self._node.vehicle.link_lost:
            self._node.receive(self._client, data)
            self._node.flush()

    def connection_lost(self, exc: Exception | None) -> None:
        if self._client is not None:
            self._node.disconnect(self._client)
            self._client = None

    def flush(self) -> None:
        """Send what waits, or drop it while the client does not read."""
        if self._client is None or self._transport is None:
            return
        data = self._node.take_output(self._client)
        if self._node.vehicle.link_lost:
            return
        if data and self._transport.get_write_buffer_size() < BUFFER_LIMIT_BYTES:
            self._transport.write(data)


class UdpEndpoint(asyncio.DatagramProtocol):
    """All UDP peers of one vehicle."""

    def __init__(self, node: Node, wall_clock: Callable[[], float]) -> None:
        self._node = node
        self._wall_clock = wall_clock
        self._peers: dict[tuple[str, int], tuple[Client, float]] = {}
        self._transport: Any = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        # asyncio's own datagram transport is no subclass of DatagramTransport and has more than that promises.
        self._transport = transport

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        if self._node.vehicle.link_lost:
            return
        known = self._peers.get(addr)
        if known is None:
            if len(self._node.clients) >= MAX_CLIENTS:
                return
            client = self._node.connect()
            client.wake = lambda: self._flush(client, addr)
            client.hang_up = lambda: self._forget(addr)
        else:
            client = known[0]
        self._peers[addr] = (client, self._wall_clock())
        self._node.receive(client, data)
        self._node.flush()

    def error_received(self, exc: Exception) -> None:
        """A peer's port is closed: it will be forgotten when it stays silent."""

    def expire(self) -> None:
        """Forget peers that have gone."""
        now = self._wall_clock()
        for addr, (client, heard) in list(self._peers.items()):
            if now - heard > UDP_SILENCE_S:
                del self._peers[addr]
                self._node.disconnect(client)

    def _forget(self, addr: tuple[str, int]) -> None:
        self._peers.pop(addr, None)

    def _flush(self, client: Client, addr: tuple[str, int]) -> None:
        """Send each message as a datagram of its own, as autopilots do."""
        for frame in () if self._node.vehicle.link_lost else client.outbox:
            if self._transport.get_write_buffer_size() < BUFFER_LIMIT_BYTES:
                self._transport.sendto(frame, addr)
        client.outbox.clear()


class Server:
    """The fleet on the network.

    Attributes
    ----------
    nodes
        The vehicles' MAVLink sides, by team index.
    """

    def __init__(
        self,
        fleet: Fleet,
        speedup: float,
        on_step: Callable[[], None] = lambda: None,
        log: Callable[[str], None] = lambda line: None,
        wall_clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.fleet = fleet
        self.nodes = [Node(vehicle, fleet.plan.datum, log) for vehicle in fleet.vehicles]
        self.late_ticks = 0
        self._step_wall_s = STEP_US * 1e-6 / speedup
        self._on_step = on_step
        self._wall_clock = wall_clock
        self._listeners: list[asyncio.Server] = []
        self._endpoints: list[tuple[asyncio.DatagramTransport, UdpEndpoint]] = []

    async def open(self) -> None:
        """Listen for every vehicle; ServerError when a port is in use."""
        host = self.fleet.plan.mission.radio.endpoint_host
        for index, node in enumerate(self.nodes):
            if self.fleet.plan.mission.vehicles[index].connection is not None:
                continue  # a real autopilot, elsewhere
            port = self.fleet.plan.mavlink_port(index)
            try:
                await self._listen(node, host, port)
            except OSError as error:
                await self.close()
                raise ServerError(_explain(error, host, port)) from None

    async def _listen(self, node: Node, host: str, port: int) -> None:
        loop = asyncio.get_running_loop()
        self._listeners.append(await loop.create_server(lambda: TcpConnection(node), host, port, reuse_address=True))
        endpoint = UdpEndpoint(node, self._wall_clock)
        transport, _ = await loop.create_datagram_endpoint(lambda: endpoint, local_addr=(host, port))
        self._endpoints.append((transport, endpoint))

    async def close(self) -> None:
        for listener in self._listeners:
            listener.close()
        for transport, _ in self._endpoints:
            transport.close()

    async def run(self, stop: asyncio.Event) -> None:
        """Let simulated time pass at the set pace until `stop` is set."""
        pacer = Pacer(self._step_wall_s, self._wall_clock())
        heartbeat_due_s = pacer.started_s + HEARTBEAT_WALL_S
        while not stop.is_set():
            now_s = self._wall_clock()
            for _ in range(pacer.steps_due(now_s)):
                self._step()
            self.late_ticks = pacer.late_ticks
            if self._slower_than_real and now_s >= heartbeat_due_s:
                heartbeat_due_s = now_s + HEARTBEAT_WALL_S
                for node in self.nodes:
                    node.say_alive()
            for node in self.nodes:
                node.flush()
            for _, endpoint in self._endpoints:
                endpoint.expire()
            await _nap(stop, max(SHORTEST_NAP_S, pacer.until_next_s(self._wall_clock())))

    @property
    def _slower_than_real(self) -> bool:
        return self._step_wall_s > STEP_US * 1e-6

    def _step(self) -> None:
        self.fleet.step(STEP_US * 1e-6)
        for node in self.nodes:
            node.tick()
        self._on_step()


async def _nap(stop: asyncio.Event, seconds: float) -> None:
    """Sleep in short pieces, so that stopping does not wait for a slow simulation."""
    while seconds > 0 and not stop.is_set():
        await asyncio.sleep(min(seconds, 0.1))
        seconds -= 0.1


def _explain(error: OSError, host: str, port: int) -> str:
    if error.errno == errno.EADDRINUSE:
        return f"MAVLink port {host}:{port} is in use; stop what holds it or choose another with --mavlink-port"
    return f"MAVLink endpoint {host}:{port} cannot be opened ({error.strerror}); correct radio.endpoint_host"
