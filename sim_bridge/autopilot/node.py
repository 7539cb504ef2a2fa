"""The autopilot as a MAVLink node: clients, parsing, dispatch and packing."""

from __future__ import annotations

from collections.abc import Callable

from sim_bridge.autopilot.available_modes import AvailableModesService
from sim_bridge.autopilot.command import CommandService, acknowledgement
from sim_bridge.autopilot.dialect import COMPONENT_ID, Message, frame_of, mavlink, new_codec, new_signing
from sim_bridge.autopilot.fence_status import FenceService
from sim_bridge.autopilot.flight import FlightService
from sim_bridge.autopilot.ftp import FtpService
from sim_bridge.autopilot.guided import GuidedService
from sim_bridge.autopilot.health import HealthService
from sim_bridge.autopilot.heartbeat import HeartbeatService
from sim_bridge.autopilot.home import HomeService
from sim_bridge.autopilot.instruments import InstrumentService
from sim_bridge.autopilot.logs import LogService
from sim_bridge.autopilot.maintenance import MaintenanceService
from sim_bridge.autopilot.mission import MissionService
from sim_bridge.autopilot.mission_progress import MissionProgressService
from sim_bridge.autopilot.param import ParameterService
from sim_bridge.autopilot.ranging import RangingService
from sim_bridge.autopilot.routing import route
from sim_bridge.autopilot.service import (
    Client,
    CommandHandler,
    CommandRequest,
    MessageBuilder,
    MessageHandler,
    Responder,
    Service,
)
from sim_bridge.autopilot.signing import SigningService
from sim_bridge.autopilot.sticks import StickService
from sim_bridge.autopilot.streams import StreamService
from sim_bridge.autopilot.telemetry import TelemetryService
from sim_bridge.autopilot.text import TextService
from sim_bridge.autopilot.time import TimeService
from sim_bridge.autopilot.version import VersionService
from sim_bridge.reply import Outcome, StatusText
from sim_bridge.vehicle import Vehicle
from vehicle_agent.domain.frames import Datum, Geodetic

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
    MissionProgressService,
    AvailableModesService,
    InstrumentService,
    RangingService,
    FtpService,
    LogService,
    SigningService,
    MaintenanceService,
    StickService,
    FenceService,
)
"""Every microservice; a new one is a file and a line here."""
MOST_LOG_LINES = 20
"""Per simulated second."""


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
        Parser errors so far: wrong bytes, and wrong signatures, are counted and dropped.
    signing
        Key and time stamps of message signing, for all connections; outlives a reboot.
    record
        Called with every frame that goes out or comes in; None while nobody keeps them.
    text_listeners
        Called with every status text.

    Example
    -------
    ::

        client = node.connect()
        node.receive(client, data_from_the_socket)
        node.tick()                       # after each simulated step
        send_to_the_socket(node.take_output(client))
    """

    def __init__(self, vehicle: Vehicle, datum: Datum, log: Callable[[str], None] = lambda line: None) -> None:
        self.vehicle = vehicle
        self.datum = datum
        self.system_id = int(vehicle.parameters[vehicle.personality.system_id_parameter])
        self.clients: list[Client] = []
        self.garbled = 0
        self.record: Callable[[bytes], None] | None = None
        self.signing = new_signing()
        self._log = log
        self._log_second = self._log_lines = 0
        self._boot()

    def _boot(self) -> None:
        """Begin with fresh services; their state is what a reboot loses."""
        self.text_listeners: list[Callable[[StatusText], None]] = []
        self.services = [service(self) for service in SERVICES]
        self.handlers: dict[str, list[MessageHandler]] = {}
        self.commands: dict[int, CommandHandler] = {}
        self.builders: dict[int, MessageBuilder] = {}
        self.responders: dict[int, Responder] = {}
        for service in self.services:
            for name, handler in service.handlers().items():
                self.handlers.setdefault(name, []).append(handler)
            self.commands.update(service.commands())
            self.builders.update(service.builders())
            self.responders.update(service.responders())
        self._ticks = [service.tick for service in self.services if type(service).tick is not Service.tick]
        self._texts = next(service for service in self.services if isinstance(service, TextService))
        self._streams = next(service for service in self.services if isinstance(service, StreamService))

    def reboot(self) -> None:
        """Break every connection off and start anew, as after switching off and on; parameters and plans stay."""
        for client in list(self.clients):
            self.disconnect(client)
            client.hang_up()
        self.vehicle.reboot()
        self.system_id = int(self.vehicle.parameters[self.vehicle.personality.system_id_parameter])
        self._boot()

    @property
    def time_boot_us(self) -> int:
        return self.vehicle.clock.elapsed_us - self.vehicle.booted_us

    @property
    def time_boot_ms(self) -> int:
        return self.time_boot_us // 1000

    def believed_place(self) -> Geodetic:
        """Where the vehicle believes to be; latitude and longitude are 0 before it knows."""
        place = self.datum.to_geodetic(self.vehicle.pilot.position_enu_m)
        return place if self.vehicle.origin_enu_m is not None else Geodetic(0.0, 0.0, place.altitude_amsl_m)

    def log(self, line: str) -> None:
        """Note something for whoever runs the simulator; a flood is cut off until the next simulated second."""
        second = self.vehicle.clock.elapsed_us // 1_000_000
        if second != self._log_second:
            self._log_second, self._log_lines = second, 0
        self._log_lines += 1
        if self._log_lines <= MOST_LOG_LINES:
            self._log(f"system {self.system_id}: {line}")

    def connect(self) -> Client:
        client = Client(new_codec(self.system_id))
        client.codec.signing = self.signing
        self.clients.append(client)
        self._streams.welcome(client)
        return client

    def disconnect(self, client: Client) -> None:
        """Forget a client; one that has gone already is no error."""
        if client not in self.clients:
            return
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
            if self.record is not None:
                self.record(message.get_msgbuf())
            if route(self, client, message):
                for handler in self.handlers.get(kind, ()):
                    handler(client, message)

    def tick(self) -> None:
        """Say what is due; call after every step of the fleet."""
        for tick in self._ticks:
            tick()

    def send(self, client: Client, message: Message) -> None:
        codec = client.codec
        frame = frame_of(message, codec)
        client.outbox.append(frame)
        if self.record is not None:
            self.record(frame)
        codec.seq = (codec.seq + 1) % 256

    def send_text(self, client: Client, status: StatusText) -> None:
        """Tell one client something that concerns only it."""
        self._texts.send(client, status)

    def acknowledge(self, request: CommandRequest, outcome: Outcome) -> None:
        self.send(request.client, acknowledgement(request, outcome))

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
