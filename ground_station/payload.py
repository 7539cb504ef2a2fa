"""What an operator's command carries beside its verb, and in which words it is shown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vehicle_agent.wire.messages import PolygonCm, PositionCm, Verb

MAX_CORNERS = 48
EastNorth = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Payload:
    """The optional fields of a `Command`."""

    point_cm: PositionCm = (0, 0, 0)
    polygon_cm: PolygonCm = ()
    number: int = 0
    subject: str = ""


NOTHING = Payload()

MEANING: dict[Verb, tuple[str, str]] = {
    Verb.HOLD: ("Hold", "stop and stay where they are"),
    Verb.RESUME: ("Resume", "go on with the mission"),
    Verb.RETURN: ("Return home", "fly home, land and disarm"),
    Verb.LAND: ("Land", "land where they are"),
    Verb.GO_TO: ("Send", "fly to the cursor and hold there"),
    Verb.VISIT: ("Visit", "fly to the cursor, then go on with the mission"),
    Verb.NO_FLY: ("No-fly zone", "keep out of it from now on"),
    Verb.AREA: ("Area", "only what lies in the polygon is to be seen"),
    Verb.SECTOR: ("Sector", "see what lies in the polygon first"),
    Verb.SPEED: ("Speed", "fly no faster than this"),
    Verb.RELEASE: ("Release", "count a teammate as lost: its goals are free"),
}
DESTRUCTIVE = frozenset({Verb.HOLD, Verb.RETURN, Verb.LAND, Verb.AREA, Verb.NO_FLY})
"""What breaks off work that is under way."""


def verb_word(verb: Verb) -> str:
    """A verb as one word for logs, e.g. `no-fly`."""
    return verb.name.lower().replace("_", "-")


def described(verb: Verb, payload: Payload) -> tuple[str, str]:
    """Name and meaning of a command with what it carries."""
    word, meaning = MEANING[verb]
    match verb:
        case Verb.GO_TO | Verb.VISIT:
            meaning = f"{meaning} (E {payload.point_cm[0] / 100:.0f} N {payload.point_cm[1] / 100:.0f} m)"
        case Verb.NO_FLY if not payload.polygon_cm:
            word, meaning = f"Lift zone {payload.number}", "fly there again"
        case Verb.NO_FLY:
            word = f"No-fly zone {payload.number}"
        case Verb.AREA if not payload.polygon_cm:
            meaning = "all of the mission's area is to be seen again"
        case Verb.SECTOR if not payload.polygon_cm:
            meaning = "no preference any more"
        case Verb.SPEED if payload.number:
            meaning = f"fly no faster than {payload.number / 100:g} m/s"
        case Verb.SPEED:
            meaning = "fly as fast as the mission says"
        case Verb.RELEASE:
            word = f"Release {payload.subject}"
    return word, meaning


def point(place_en_m: EastNorth) -> Payload:
    """A place of the plane; its height is the vehicle's own choice."""
    return Payload(point_cm=(round(100 * place_en_m[0]), round(100 * place_en_m[1]), 0))


def polygon(corners_en_m: Sequence[EastNorth], number: int = 0) -> Payload:
    """A polygon by its corners; what has more than a command can carry is thinned evenly."""
    step = max(1, -(-len(corners_en_m) // MAX_CORNERS))
    corners = corners_en_m[::step]
    return Payload(polygon_cm=tuple((round(100 * e), round(100 * n)) for e, n in corners), number=number)
