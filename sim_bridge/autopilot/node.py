"""The autopilot as a MAVLink node: clients, parsing, dispatch and packing."""

from __future__ import annotations

from sim_bridge.autopilot.command import CommandService
from sim_bridge.autopilot.dialect import COMPONENT_ID, Message, mavlink, new_codec
from sim_bridge.autopilot.flight import FlightService
from sim_bridge.autopilot.guided import GuidedService
from sim_bridge.autopilot.health import HealthService
from sim_bridge.autopilot.heartbeat import HeartbeatService
from sim_bridge.autopilot.home import HomeService
from sim_bridge.autopilot.mission import MissionService
from sim_bridge.autopilot.param import ParameterService
from sim_bridge.autopilot.routing import route
from sim_bridge.autopilot.service import Client, CommandHandler, MessageBuilder, MessageHandler, Service
from sim_bridge.autopilot.streams import StreamService
from sim_bridge.autopilot.telemetry import TelemetryService
from sim_bridge.autopilot.text import TextService
from sim_bridge.autopilot.time import TimeService
from sim_bridge.autopilot.version import VersionService
from sim_bridge.vehicle import Vehicle
from vehicle_agent.domain.frames import Datum

SERVICES: tuple[type[Service], ...] = (
    HeartbeatService,
    TextService,
    CommandService,
    VersionService,
    TimeService,
    ParameterService,
    StreamService,
    TelemetryService,
    HealthService,
    HomeService,
    FlightService,
    GuidedService,
    MissionService,
)
"""Every microservice; a new one is a file and a line here."""


class Node:
    """One vehicle's MAVLink side.

    Attributes
    ----------
    vehicle
        What it speaks for.
    datum
        Of the mission's frame.
    clients
        Those connected now.
    garbled
        Parser errors so far: wrong bytes are counted and dropped.

    Example
    -------
    ::

        client = node.connect()
        node.receive(client, data_from_the_socket)
        node.tick()                       # after each simulated step
        send_to_the_socket(node.take_output(client))
    """

    def __init__(self, vehicle: Vehicle, datum: Datum) -> None:
        self.vehicle = vehicle
        self.datum = datum
        self.system_id = int(vehicle.parameters[vehicle.personality.system_id_parameter])
        self.clients: list[Client] = []
        self.garbled = 0
        self.services = [service(self) for service in SERVICES]
        self.handlers: dict[str, list[MessageHandler]] = {}
        self.commands: dict[int, CommandHandler] = {}
        self.builders: dict[int, MessageBuilder] = {}
        for service in self.services:
            for name, handler in service.handlers().items():
                self.handlers.setdefault(name, []).append(handler)
            self.commands.update(service.commands())
            self.builders.update(service.builders())

    @property
    def time_boot_ms(self) -> int:
        return self.vehicle.clock.elapsed_us // 1000

    def connect(self) -> Client:
        client = Client(new_codec(self.system_id))
        self.clients.append(client)
        return client

    def disconnect(self, client: Client) -> None:
        self.clients.remove(client)
        for service in self.services:
            service.forget(client)

    def receive(self, client: Client, data: bytes) -> None:
        """Take bytes from a client; answers are in outboxes when this returns. Never raises for wrong bytes."""
        for message in client.codec.parse_buffer(data) or ():
            kind = message.get_type()
            if kind == "BAD_DATA":
                self.garbled += 1
                continue
            if route(self, client, message):
                for handler in self.handlers.get(kind, ()):
                    handler(client, message)

    def tick(self) -> None:
        """Say what is due; call after every step of the fleet."""
        for service in self.services:
            service.tick()

    def send(self, client: Client, message: Message) -> None:
        codec = client.codec
        client.outbox.append(message.pack(codec))
        codec.seq = (codec.seq + 1) % 256

    def broadcast(self, message: Message) -> None:
        for client in self.clients:
            self.send(client, message)

    def say_alive(self) -> None:
        """Send a heartbeat beyond those of simulated time."""
        self.broadcast(self.builders[mavlink.MAVLINK_MSG_ID_HEARTBEAT]())

    def flush(self) -> None:
        """Wake every connection that has something to send."""
        for client in self.clients:
            if client.outbox:
                client.wake()

    def take_output(self, client: Client) -> bytes:
        """Everything that waits for a client, as one byte string."""
        data = b"".join(client.outbox)
        client.outbox.clear()
        return data


__all__ = ["COMPONENT_ID", "SERVICES", "Node"]
