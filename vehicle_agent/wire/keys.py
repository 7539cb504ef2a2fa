"""Keys on Zenoh and the one table that says how each topic travels."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum

from vehicle_agent.wire.messages import (
    NAME_PATTERN,
    AnyMessage,
    BodyReport,
    Claim,
    Command,
    CommandResult,
    Digest,
    Event,
    LandmarkDigest,
    Landmarks,
    MapDelta,
    Orders,
    Repair,
    Scan,
    Status,
)

WIRE_VERSION = "v1"
ALIVE = "alive"
"""Last part of the key of a participant's liveliness token."""
_NAME = re.compile(NAME_PATTERN)


class Delivery(Enum):
    """What happens when the link is too slow or away."""

    LATEST = "latest"
    """Telemetry: dropped rather than waited for."""
    BULK = "bulk"
    """Map data: waits its turn on a thread of its own; losses are mended by digests."""
    RECOVERED = "recovered"
    """Events and commands: cached by the sender, recovered after an outage, shown to late joiners."""


class Urgency(Enum):
    """Order of topics on a thin link."""

    HIGH = "high"
    NORMAL = "normal"
    LOW = "low"


@dataclass(frozen=True, slots=True)
class Topic:
    """How one kind of message travels.

    Attributes
    ----------
    name
        Last part of the key.
    message
        The one type said on it.
    period_s
        Nominal time between two messages of one sender, in vehicle time; None when sent on occasion.
    bytes_per_message
        Budget of an ordinary message.
    history
        Messages that a late joiner still gets (only with `Delivery.RECOVERED`).
    over_radio
        False for what stays on one machine: not counted in a vehicle's bytes sent.
    """

    name: str
    message: type[AnyMessage]
    period_s: float | None
    delivery: Delivery
    urgency: Urgency
    bytes_per_message: int
    history: int = 0
    over_radio: bool = True


TOPICS: tuple[Topic, ...] = (
    Topic("status", Status, 1.0, Delivery.LATEST, Urgency.HIGH, 260),
    Topic("map", MapDelta, 2.0, Delivery.BULK, Urgency.LOW, 1_500),
    Topic("claim", Claim, None, Delivery.LATEST, Urgency.HIGH, 200),
    Topic("event", Event, None, Delivery.RECOVERED, Urgency.NORMAL, 240, history=50),
    Topic("command", Command, None, Delivery.RECOVERED, Urgency.HIGH, 200, history=20),
    Topic("result", CommandResult, None, Delivery.RECOVERED, Urgency.HIGH, 240, history=20),
    Topic("orders", Orders, None, Delivery.RECOVERED, Urgency.NORMAL, 300, history=1),
    Topic("digest", Digest, 5.0, Delivery.LATEST, Urgency.NORMAL, 200),
    Topic("repair", Repair, None, Delivery.BULK, Urgency.LOW, 8_000),
    Topic("landmarks", Landmarks, 10.0, Delivery.LATEST, Urgency.NORMAL, 200),
    Topic("landmark-digest", LandmarkDigest, 60.0, Delivery.LATEST, Urgency.LOW, 140),
    Topic("scan", Scan, 1.0, Delivery.LATEST, Urgency.NORMAL, 8_000, over_radio=False),
    Topic("body", BodyReport, 1.0, Delivery.LATEST, Urgency.NORMAL, 120, over_radio=False),
)

TOPIC_BY_NAME = {topic.name: topic for topic in TOPICS}
TOPIC_BY_MESSAGE = {topic.message: topic for topic in TOPICS}


def topic_of(message: AnyMessage) -> Topic:
    return TOPIC_BY_MESSAGE[type(message)]


def key(mission: str, participant: str, topic: Topic | str) -> str:
    """Key of one participant's topic; `*` as participant or topic makes a key expression for all of them."""
    return f"fleet/{mission}/{WIRE_VERSION}/{participant}/{topic if isinstance(topic, str) else topic.name}"


def alive_key(mission: str, participant: str) -> str:
    """Key of the liveliness token by which a participant's death is noticed."""
    return key(mission, participant, ALIVE)


def parse(key_text: str) -> tuple[str, str, str] | None:
    """Mission, participant and topic name of a key; None for a key that is not ours or of another wire version."""
    parts = key_text.split("/")
    if len(parts) != 5 or parts[0] != "fleet" or parts[2] != WIRE_VERSION:
        return None
    _, mission, _, participant, topic = parts
    if not (_NAME.match(mission) and _NAME.match(participant) and (topic in TOPIC_BY_NAME or topic == ALIVE)):
        return None
    return (mission, participant, topic)
