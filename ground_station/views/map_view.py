"""The map: ground, frontiers, trails, ways, goals and vehicles, two pixels to a character where Unicode is there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from ground_station.picture import Condition, FleetState, VehiclePicture, metres
from ground_station.views import palette
from ground_station.views.ink import Ink, Line, Look, Rgb, Span
from ground_station.views.raster import FRONTIER, OBSERVED, Raster, rasterise, segment_pixels
from ground_station.views.viewport import Viewport
from vehicle_agent.wire.messages import PositionCm

RAMP_STEPS = 16
TRAIL_POINTS = 60
"""How much of a trail is drawn: the newest part, so that the ground stays readable."""
ASCII_RAMP = "-=+*%@"
Pixels = list[list[Rgb | None]]
"""[y][x] colours; None leaves the terminal's own."""
Marks = dict[tuple[int, int], Span]
"""(x, y) of a character to what stands there instead of the ground."""


def map_raster(state: FleetState, width: int, height: int, look: Look, former: Raster | None = None) -> Raster:
    """The ground for a map of `width` x `height` characters; `former` again when it still holds."""
    blocks = _in_blocks(look)
    width, height = max(1, width), max(1, height)
    view = Viewport.around(state.plan.grid, width, 2 * height if blocks else height, 1.0 if blocks else 2.0)
    if former is not None and (former.version, former.view) == (state.team_map.version, view):
        return former
    return rasterise(state.team_map, view)


def map_lines(state: FleetState, raster: Raster, look: Look) -> list[Line]:
    """The raster with everything on it, north up: one line per row of characters."""
    view = raster.view
    if not _in_blocks(look):
        return _character_lines(state, raster, view, _marks(state, view, look, rows_per_character=1), look)
    marks = _marks(state, view, look, rows_per_character=2)
    pixels = _ground_colours(raster)
    _draw_ways(state, view, pixels)
    return [_block_line(pixels[row], pixels[row + 1], row // 2, marks) for row in range(0, view.height, 2)]


def _in_blocks(look: Look) -> bool:
    return look.unicode and look.colour


def caption(raster: Raster, width: int, look: Look) -> Line:
    """What the colours mean: lowest and highest ground seen, and the glyphs on the map."""
    ramp: list[Span]
    if _in_blocks(look):
        ramp = [(" ", Ink(bg=colour)) for colour in palette.cividis(8)]
    else:
        ramp = [(character, _character_ink(code, look)) for code, character in enumerate(ASCII_RAMP, 3)]
    heights: list[Span] = [(f"{raster.lowest_m:.0f}", Ink()), *ramp, (f"{raster.highest_m:.0f} m", Ink())]
    quiet = look.ink(palette.QUIET)
    goal, home = look.glyph("◇", "x"), look.glyph("⌂", "H")
    legend: list[Span] = [(f"  {goal} goal {home} home", quiet)]
    frontier = (" ", Ink(bg=palette.FRONTIER)) if _in_blocks(look) else ("~", Ink())
    if width >= 45:
        legend += [("  ", quiet), frontier, (" frontier", quiet)]
    return (*heights, *legend)


def _ground_colours(raster: Raster) -> Pixels:
    ramp = palette.cividis(RAMP_STEPS)
    steps = np.minimum((raster.height_share * RAMP_STEPS).astype(np.int64), RAMP_STEPS - 1)
    table: list[Rgb | None] = [None, palette.UNOBSERVED, palette.FRONTIER, *ramp]
    codes = np.where(raster.kind == OBSERVED, steps + 3, np.where(raster.kind == FRONTIER, 2, raster.kind))
    return [[table[code] for code in row] for row in codes.T.tolist()]


def _draw_ways(state: FleetState, view: Viewport, pixels: Pixels) -> None:
    """Trails dim, reserved legs bright, the way beyond dotted."""
    for vehicle in state.vehicles:
        if vehicle.status is None:
            continue
        colour = palette.vehicle_colour(vehicle.index)
        for x, y in dict.fromkeys(_line_pixels(vehicle.trail_en_m[-TRAIL_POINTS:], view)):
            ground = pixels[y][x]
            if ground is not None:
                pixels[y][x] = palette.blend(ground, colour, 0.3)
        if vehicle.condition in (Condition.LOST, Condition.LEFT):
            continue
        leg, path = _way(vehicle)
        for place, (x, y) in enumerate(_line_pixels(path, view)):
            if place % 2 == 0:
                pixels[y][x] = colour
        for x, y in _line_pixels(leg, view):
            pixels[y][x] = colour


def _way(vehicle: VehiclePicture) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """The reserved leg, and the planned way after it, as (east, north) corners."""
    assert vehicle.status is not None
    leg = [_plane(vehicle.status.position_cm), _plane(vehicle.status.leg_end_cm)]
    return leg, [leg[1], *(_plane(corner) for corner in vehicle.status.path_cm)]


def _plane(position_cm: PositionCm) -> tuple[float, float]:
    east_m, north_m, _ = metres(position_cm)
    return (east_m, north_m)


def _line_pixels(corners: Sequence[tuple[float, float]], view: Viewport) -> Iterator[tuple[int, int]]:
    pixels = [view.pixel_of(east_m, north_m) for east_m, north_m in corners]
    for start, end in pairwise(pixels):
        yield from segment_pixels(start, end, view)


def _marks(state: FleetState, view: Viewport, look: Look, rows_per_character: int) -> Marks:
    """Homes, goals and vehicles, the more important later and so on top."""
    marks: Marks = {}

    def put(east_m: float, north_m: float, text: str, ink: Ink) -> None:
        x, y = view.pixel_of(east_m, north_m)
        if view.holds(x, y):
            start = x if x + len(text) <= view.width else view.width - len(text)
            for offset, character in enumerate(text):
                marks[start + offset, y // rows_per_character] = (character, ink)

    heard = [vehicle for vehicle in state.vehicles if vehicle.status is not None]
    for vehicle in heard:
        assert vehicle.status is not None
        if vehicle.status.home_cm != (0, 0, 0):
            put(*_plane(vehicle.status.home_cm), look.glyph("⌂", "H"), look.ink(palette.HOME, dim=True))
    for vehicle in heard:
        claim = vehicle.claim
        if claim is not None and claim.active and vehicle.condition in (Condition.LIVE, Condition.SUSPECT):
            ink = look.ink(palette.vehicle_colour(vehicle.index), palette.UNOBSERVED, bold=True)
            put(*_plane(claim.goal_cm), look.glyph("◇", "x"), ink)
    for vehicle in sorted(heard, key=lambda one: one.condition is Condition.LOST):
        position = vehicle.position_enu_m
        assert position is not None
        put(position[0], position[1], _vehicle_text(vehicle, look), _vehicle_ink(vehicle, look))
    return marks


def _vehicle_text(vehicle: VehiclePicture, look: Look) -> str:
    assert vehicle.status is not None
    number = str(vehicle.index + 1)
    if vehicle.condition is Condition.LOST:
        return number + look.glyph("✖", "X")
    if not vehicle.status.armed:
        return number + look.glyph("·", ".")
    if look.unicode:
        return number + "↑↗→↘↓↙←↖"[round(vehicle.status.heading_deg / 45) % 8]
    return number + "^>v<"[round(vehicle.status.heading_deg / 90) % 4]


def _vehicle_ink(vehicle: VehiclePicture, look: Look) -> Ink:
    if not look.colour:
        return Ink(bold=True, reverse=True)
    if vehicle.condition is Condition.LOST:
        return Ink((0, 0, 0), palette.BAD, bold=True)
    return Ink((0, 0, 0), palette.vehicle_colour(vehicle.index), bold=True)


def _block_line(upper: list[Rgb | None], lower: list[Rgb | None], row: int, marks: Marks) -> Line:
    """One line of characters from two rows of pixels; equal neighbours share a span."""
    spans: list[Span] = []
    for x, (top, bottom) in enumerate(zip(upper, lower, strict=True)):
        mark = marks.get((x, row))
        if mark is not None:
            text, ink = mark
            if ink.bg is None:
                ink = Ink(ink.fg, bottom, ink.bold, ink.dim, ink.reverse)
        elif top == bottom:
            text, ink = " ", Ink(bg=top)
        elif top is None:
            text, ink = "▄", Ink(fg=bottom)
        else:
            text, ink = "▀", Ink(fg=top, bg=bottom)
        if spans and spans[-1][1] == ink:
            spans[-1] = (spans[-1][0] + text, ink)
        else:
            spans.append((text, ink))
    return tuple(spans)


def _character_lines(state: FleetState, raster: Raster, view: Viewport, marks: Marks, look: Look) -> list[Line]:
    """The map in plain characters: `.` unobserved, `~` frontier, a ramp for height, `,` trail and `:` way."""
    steps = np.minimum((raster.height_share * len(ASCII_RAMP)).astype(np.int64), len(ASCII_RAMP) - 1)
    table = " .~" + ASCII_RAMP
    codes = np.where(raster.kind == OBSERVED, steps + 3, np.where(raster.kind == FRONTIER, 2, raster.kind))
    rows = [[(table[code], _character_ink(code, look)) for code in row] for row in codes.T.tolist()]
    for vehicle in state.vehicles:
        if vehicle.status is None or vehicle.condition in (Condition.LOST, Condition.LEFT):
            continue
        ink = look.ink(palette.vehicle_colour(vehicle.index), bold=True)
        leg, path = _way(vehicle)
        for x, y in [*_line_pixels(path, view), *_line_pixels(leg, view)]:
            rows[y][x] = (":", ink)
    for (x, y), mark in marks.items():
        rows[y][x] = mark
    return [_joined(row) for row in rows]


def _character_ink(code: int, look: Look) -> Ink:
    if not look.colour:
        return Ink(dim=code == 1)
    if code == 2:
        return Ink(palette.FRONTIER)
    return Ink(palette.QUIET, dim=True) if code < 2 else Ink(palette.cividis(len(ASCII_RAMP))[code - 3])


def _joined(spans: list[Span]) -> Line:
    joined: list[Span] = []
    for text, ink in spans:
        if joined and joined[-1][1] == ink:
            joined[-1] = (joined[-1][0] + text, ink)
        else:
            joined.append((text, ink))
    return tuple(joined)
