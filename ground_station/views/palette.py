"""Colours that people with any colour vision tell apart, and the glyph that goes with every state."""

from __future__ import annotations

from functools import lru_cache

from ground_station.picture import Condition, VehiclePicture
from ground_station.views.ink import Rgb
from vehicle_agent.wire.messages import Severity, Stage

CIVIDIS_ANCHORS: tuple[Rgb, ...] = (
    (0x00, 0x20, 0x4D),
    (0x00, 0x33, 0x6F),
    (0x39, 0x48, 0x6B),
    (0x57, 0x5C, 0x6D),
    (0x70, 0x71, 0x73),
    (0x8A, 0x87, 0x79),
    (0xA6, 0x9D, 0x75),
    (0xC4, 0xB5, 0x6C),
    (0xE4, 0xCF, 0x5B),
    (0xFF, 0xEA, 0x46),
)
"""Ten evenly spaced colours of cividis (Nunez, Anderton and Renslow 2018, doi:10.1371/journal.pone.0199239)."""

VEHICLE_COLOURS: tuple[Rgb, ...] = (
    (0xFF, 0x9F, 0x1C),
    (0x56, 0xC4, 0xF9),
    (0x2C, 0xD8, 0x9A),
    (0xFF, 0x8A, 0xC8),
    (0xF4, 0xF1, 0xE8),
    (0xFF, 0x6B, 0x4A),
    (0xB9, 0x9C, 0xFF),
    (0xC6, 0xE8, 0x4C),
)
"""After Okabe and Ito's set, lightened to stand out on dark ground; the number beside a vehicle tells more."""

UNOBSERVED: Rgb = (0x14, 0x16, 0x1A)
FRONTIER: Rgb = (0xE8, 0xE8, 0xF4)
HOME: Rgb = (0xFF, 0xFF, 0xFF)
GOOD: Rgb = (0x2C, 0xD8, 0x9A)
WARN: Rgb = (0xF4, 0xD0, 0x3F)
BAD: Rgb = (0xFF, 0x6B, 0x4A)
QUIET: Rgb = (0x8C, 0x93, 0x9E)
ACCENT: Rgb = (0x56, 0xC4, 0xF9)
BAR: Rgb = (0x1E, 0x24, 0x2E)


def cividis(steps: int) -> tuple[Rgb, ...]:
    """The ramp in `steps` colours, linear between the anchors, dark to light."""
    colours: list[Rgb] = []
    for step in range(steps):
        place = step / max(1, steps - 1) * (len(CIVIDIS_ANCHORS) - 1)
        low = min(int(place), len(CIVIDIS_ANCHORS) - 2)
        colours.append(blend(CIVIDIS_ANCHORS[low], CIVIDIS_ANCHORS[low + 1], place - low))
    return tuple(colours)


@lru_cache(maxsize=4096)
def blend(start: Rgb, end: Rgb, share: float) -> Rgb:
    red, green, blue = (round(a + (b - a) * share) for a, b in zip(start, end, strict=True))
    return (red, green, blue)


def vehicle_colour(index: int) -> Rgb:
    return VEHICLE_COLOURS[index % len(VEHICLE_COLOURS)]


STAGE_WORDS: dict[Stage, str] = {
    Stage.CONNECTING: "connecting",
    Stage.CONFIGURING: "configures",
    Stage.ARMING: "arming",
    Stage.TAKING_OFF: "takes off",
    Stage.WORKING: "working",
    Stage.HOLDING: "holding",
    Stage.RETURNING: "returning",
    Stage.LANDING: "landing",
    Stage.DONE: "done",
    Stage.YIELDED: "yielded",
    Stage.REFUSED: "refused",
}


def state_word(vehicle: VehiclePicture) -> str:
    """What a vehicle is at, in one or two words of at most ten columns."""
    if vehicle.condition in (Condition.AWAITED, Condition.LOST):
        return str(vehicle.condition.value)
    return STAGE_WORDS[vehicle.status.stage] if vehicle.status else str(vehicle.condition.value)


def state_mark(vehicle: VehiclePicture) -> tuple[str, str, Rgb]:
    """Unicode glyph, ASCII glyph and colour of a vehicle's state; every state has a glyph of its own."""
    match vehicle.condition:
        case Condition.AWAITED:
            return ("○", ".", QUIET)
        case Condition.LOST:
            return ("✖", "X", BAD)
        case Condition.SUSPECT:
            return ("◐", "?", WARN)
    match vehicle.status.stage if vehicle.status else Stage.CONNECTING:
        case Stage.DONE:
            return ("✔", "+", ACCENT)
        case Stage.REFUSED | Stage.YIELDED:
            return ("▲", "!", BAD)
        case Stage.HOLDING:
            return ("■", "=", WARN)
        case Stage.RETURNING | Stage.LANDING:
            return ("◀", "<", ACCENT)
        case Stage.WORKING:
            return ("●", "*", GOOD)
    return ("◌", "o", QUIET)


def severity_mark(severity: Severity) -> tuple[str, str, Rgb | None]:
    """Unicode glyph, ASCII glyph and colour of an event's severity."""
    if severity <= Severity.ERROR:
        return ("✖", "X", BAD)
    if severity is Severity.WARNING:
        return ("▲", "!", WARN)
    return ("•", "-", None) if severity is Severity.NOTICE else ("·", ".", QUIET)
