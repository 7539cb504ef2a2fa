"""What a microservice of the autopilot looks like, and what it works on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from sim_bridge.autopilot.dialect import Message
from sim_bridge.reply import Outcome

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node


@dataclass(slots=True, eq=False)
class Client:
    """One connection to the vehicle, e.g. a TCP connection or a UDP peer.

    Attributes
    ----------
    codec
        Parser and sequence numbers of this connection.
    outbox
        Packed messages that wait to be sent.
    routes
        (system id, component id) heard on this connection.
    wake
        Called by the node's `flush` when something waits; set by whoever owns the socket.
    hang_up
        Called when the vehicle breaks the connection off; set by whoever owns the socket.
    """

    codec: Any
    outbox: list[bytes] = field(default_factory=list)
    routes: set[tuple[int, int]] = field(default_factory=set)
    wake: Callable[[], None] = lambda: None
    hang_up: Callable[[], None] = lambda: None


@dataclass(frozen=True, slots=True)
class CommandRequest:
    """A command, whether it came as COMMAND_LONG or as COMMAND_INT.

    Attributes
    ----------
    parameters
        1 to 4.
    x, y
        COMMAND_INT's integers (1e7 degrees for places), or parameters 5 and 6 of COMMAND_LONG.
    z
        Parameter 7.
    frame
        MAV_FRAME of a COMMAND_INT; None with COMMAND_LONG.
    sender
        System and component id of who asks.
    afterwards
        Messages that follow the acknowledgement to the same client.
    """

    client: Client
    command: int
    parameters: tuple[float, float, float, float]
    x: float
    y: float
    z: float
    frame: int | None
    sender: tuple[int, int] = (0, 0)
    afterwards: list[Message] = field(default_factory=list)


MessageHandler = Callable[[Client, Message], None]
CommandHandler = Callable[[CommandRequest], Outcome]
MessageBuilder = Callable[[], Message | None]
Responder = Callable[[CommandRequest], list[Message]]


class Service:
    """A microservice. Subclasses override what they have; the node looks once, when it is built."""

    def __init__(self, node: Node) -> None:
        self.node = node

    def handlers(self) -> dict[str, MessageHandler]:
        """Messages it takes, by name."""
        return {}

    def commands(self) -> dict[int, CommandHandler]:
        """Commands it carries out, by MAV_CMD."""
        return {}

    def builders(self) -> dict[int, MessageBuilder]:
        """Messages it can build on request or as a stream, by id; a builder returns None while it has nothing."""
        return {}

    def responders(self) -> dict[int, Responder]:
        """Messages, by id, that are told on request only and depend on the request's parameters."""
        return {}

    def tick(self) -> None:
        """Do what is due at this instant of simulated time."""

    def forget(self, client: Client) -> None:
        """Drop what is kept for a client that has gone."""
