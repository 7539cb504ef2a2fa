"""The roster: every vehicle's state, mode, battery, link age, share of the map and reason."""

from __future__ import annotations

from ground_station.picture import Condition, FleetState, VehiclePicture
from ground_station.text import age, data_rate
from ground_station.views import palette
from ground_station.views.ink import PLAIN, Line, Look, Span, line_of, wrapped
from vehicle_agent.wire.messages import Severity

WIDE = 56
"""Columns from which bytes per second are shown too."""
LOW_BATTERY = 250
"""Permille below which the charge is shown as a warning."""


def roster_lines(state: FleetState, width: int, height: int, look: Look, selected: str = "") -> list[Line]:
    """A head and two or three lines per vehicle, the most troubled first; one line each where there is not room, and a
    count of the rest where even that is too much."""
    lines = [_head(look)]
    room = height - 1
    vehicles = by_trouble(state)
    if room >= 2 * len(vehicles):
        reason_lines = 2 if room >= 3 * len(vehicles) else 1
        for vehicle in vehicles:
            lines += [
                _first_line(state, vehicle, look, selected),
                *_reason(state, vehicle, width, reason_lines, look),
            ]
        return lines
    if room >= len(vehicles):
        return lines + [_first_line(state, vehicle, look, selected) for vehicle in vehicles]
    shown = max(0, room - 1)
    first = [vehicle for vehicle in vehicles if vehicle.name == selected and vehicle not in vehicles[:shown]]
    vehicles = [*first, *(vehicle for vehicle in vehicles if vehicle not in first)]
    lines += [_first_line(state, vehicle, look, selected) for vehicle in vehicles[:shown]]
    return [*lines, line_of((f"   and {len(vehicles) - shown} more, less troubled", look.ink(palette.QUIET)))]


def by_trouble(state: FleetState) -> list[VehiclePicture]:
    """The vehicles, those with the worst trouble first, else in the mission's order."""
    ranks: dict[str, tuple[int, int]] = {}
    for trouble in state.audible_troubles:
        rank = (int(trouble.severity), int(trouble.acknowledged))
        ranks[trouble.vehicle] = min(rank, ranks.get(trouble.vehicle, rank))
    untroubled = {Condition.AWAITED: 101, Condition.LEFT: 102}

    def place(vehicle: VehiclePicture) -> tuple[tuple[int, int], int]:
        return (ranks.get(vehicle.name, (untroubled.get(vehicle.condition, 100), 0)), vehicle.index)

    return sorted(state.vehicles, key=place)


def _head(look: Look) -> Line:
    return line_of((f"   {'vehicle':<10}{'  state':<13}{'mode':<8}{'batt':>4}{'age':>5}", look.ink(palette.QUIET)))


def _first_line(state: FleetState, vehicle: VehiclePicture, look: Look, selected: str) -> Line:
    unicode_mark, ascii_mark, colour = palette.state_mark(vehicle)
    name = vehicle.name if len(vehicle.name) <= 10 else vehicle.name[:9] + look.glyph("…", ".")
    pointer = look.glyph("▸", ">") if vehicle.name == selected else " "
    spans: list[Span | str] = [
        (f"{vehicle.index + 1:>2}{pointer}", look.ink(palette.vehicle_colour(vehicle.index), bold=True)),
        (f"{name:<10} ", look.ink(palette.vehicle_colour(vehicle.index), bold=True)),
        (f"{look.glyph(unicode_mark, ascii_mark)} {palette.state_word(vehicle):<10} ", look.ink(colour)),
    ]
    status = vehicle.status
    if status is None:
        return line_of(*spans)
    battery = "  --" if status.battery_permille < 0 else f"{status.battery_permille / 10:3.0f}%"
    low = 0 <= status.battery_permille < LOW_BATTERY
    silence_s = vehicle.age_s(state.now_s) or 0.0
    stale = vehicle.condition in (Condition.SUSPECT, Condition.LOST)
    spans += [
        f"{status.mode[:7]:<7} ",
        (battery, look.ink(palette.BAD, bold=True) if low else PLAIN),
        (f"{age(silence_s):>5}", look.ink(palette.WARN, bold=True) if stale else look.ink(palette.QUIET)),
    ]
    return line_of(*spans)


def _reason(state: FleetState, vehicle: VehiclePicture, width: int, lines: int, look: Look) -> list[Line]:
    """Share of the area first seen, on wide terminals bytes per second, and why it goes where it goes."""
    quiet = look.ink(palette.QUIET)
    if vehicle.status is None:
        text = "its agent is up, no status yet" if vehicle.alive else "not heard yet"
        return [line_of((f"     {text}", quiet)), *[()] * (lines - 1)]
    share = 100 * state.team_map.first_seen_share(vehicle.index)
    rate = f" {data_rate(vehicle.bytes_per_s):>8}" if width >= WIDE else ""
    numbers = f"{share:8.1f}%{rate} "
    trouble = next((one for one in state.audible_troubles if one.vehicle == vehicle.name), None)
    why = vehicle.status.why if trouble is None else f"{trouble.kind.value}: {trouble.text}"
    pieces = wrapped(why, max(8, width - len(numbers)))
    if len(pieces) > lines:
        pieces = [*pieces[: lines - 1], " ".join(pieces[lines - 1 :])]
    pieces += [""] * (lines - len(pieces))
    first, *rest = pieces
    ink = quiet if vehicle.condition in (Condition.LOST, Condition.LEFT) else PLAIN
    if trouble is not None and not trouble.acknowledged:
        ink = look.ink(palette.BAD if trouble.severity <= Severity.ERROR else palette.WARN)
    return [line_of((numbers, quiet), (first, ink)), *(line_of((" " * len(numbers) + piece, ink)) for piece in rest)]
