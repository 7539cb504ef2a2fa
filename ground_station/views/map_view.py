"""The map: ground, frontiers, trails, ways, goals and vehicles, two pixels to a character where Unicode is there."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ground_station.picture import Condition, FleetState, VehiclePicture, metres
from ground_station.text import duration
from ground_station.views import palette
from ground_station.views.ink import Ink, Line, Look, Rgb, Span
from ground_station.views.raster import FRONTIER, NEEDS_TELLING, OBSERVED, Raster, line_pixels, rasterise
from ground_station.views.viewport import Viewport
from ground_station.views.window import Ground, Layer, MapWindow, scale_bar
from ground_station.views.zones import ZonePixels, zone_pixels
from vehicle_agent.wire.messages import PositionCm

RAMP_STEPS = 16
TRAIL_POINTS = 60
"""How much of a trail is drawn: the newest part, so that the ground stays readable."""
ASCII_RAMP = "-=+*%@"
WHOLE = MapWindow()
SCALE_CHARACTERS = 8
Pixels = list[list[Rgb | None]]
"""[y][x] colours; None leaves the terminal's own."""
Marks = dict[tuple[int, int], Span]
"""(x, y) of a character to what stands there instead of the ground."""


def map_raster(
    state: FleetState,
    width: int,
    height: int,
    look: Look,
    former: Raster | None = None,
    window: MapWindow = WHOLE,
) -> Raster:
    """The ground for a map of `width` x `height` characters; `former` again when it still holds."""
    blocks = _in_blocks(look)
    width, height = max(1, width), max(1, height)
    view = window.viewport(state.plan.grid, width, 2 * height if blocks else height, 1.0 if blocks else 2.0)
    wanted = (state.team_map.version, view, window.ground)
    same = former is not None and (former.version, former.view, former.ground) == wanted
    if former is not None and same and former.landmarks is state.landmarks:
        return former
    return rasterise(state.team_map, view, window.ground, state.landmarks)


def map_lines(state: FleetState, raster: Raster, look: Look, window: MapWindow = WHOLE) -> list[Line]:
    """The raster with everything on it, north up: one line per row of characters."""
    view = raster.view
    rows = rows_per_character(look)
    marks = _marks(state, view, look, window, rows)
    zones = zone_pixels(state, view, window)
    if not _in_blocks(look):
        return _character_lines(state, raster, view, marks, zones, look, window)
    pixels = _ground_colours(raster, window)
    _draw_zones(zones, pixels)
    _draw_ways(state, view, pixels, window)
    by_row: dict[int, list[tuple[int, Span]]] = {}
    for (x, y), mark in sorted(marks.items()):
        by_row.setdefault(y, []).append((x, mark))
    return [
        _block_line(tuple(pixels[row]), tuple(pixels[row + 1]), tuple(by_row.get(row // 2, ())))
        for row in range(0, view.height, 2)
    ]


def rows_per_character(look: Look) -> int:
    """Pixels of the raster above each other in one character."""
    return 2 if _in_blocks(look) else 1


def _in_blocks(look: Look) -> bool:
    return look.unicode and look.colour


def caption(raster: Raster, width: int, look: Look, started_ms: int = 0) -> Line:
    """What the colours mean, a scale bar, and the glyphs on the map as far as there is room."""
    quiet = look.ink(palette.QUIET)
    spans = [*_ramp(raster, look, started_ms), ("  ", quiet)]
    metres_per_character = raster.view.pixel_width_m
    length, label = scale_bar(metres_per_character, SCALE_CHARACTERS)
    bar = look.glyph("├", "|") + look.glyph("─", "-") * max(0, length - 2) + look.glyph("┤", "|")
    spans.append((f"{bar[:length]} {label}", quiet))
    goal, home = look.glyph("◇", "x"), look.glyph("⌂", "H")
    frontier = (" ", Ink(bg=palette.FRONTIER)) if _in_blocks(look) else ("~", Ink())
    legends = [[(f"  {goal} goal {home} home", quiet)]]
    if raster.landmarks is None:
        legends.append([("  ", quiet), frontier, (" frontier", quiet)])
    for legend in legends:
        if sum(len(text) for text, _ in (*spans, *legend)) <= width:
            spans += legend
    return tuple(spans)


def _ramp(raster: Raster, look: Look, started_ms: int) -> list[Span]:
    quiet = look.ink(palette.QUIET)
    if raster.ground is Ground.SEEN_BY:
        return [("seen first by: colours", quiet)]
    if raster.ground is Ground.OBSERVED:
        return [("light: observed", quiet)]
    if raster.ground in NEEDS_TELLING and (raster.ground is Ground.BELIEF or raster.landmarks is None):
        return [(f"{raster.ground.value}: not told in this mission", look.ink(palette.WARN))]
    ramp: list[Span]
    if _in_blocks(look):
        ramp = [(" ", Ink(bg=colour)) for colour in palette.cividis(8)]
    else:
        ramp = [(character, _character_ink(code, look)) for code, character in enumerate(ASCII_RAMP, 3)]
    if raster.ground is Ground.SEEN_WHEN:
        first_s, last_s = ((stamp_ms - started_ms) / 1_000 if stamp_ms else 0.0 for stamp_ms in _ends_ms(raster))
        return [(duration(first_s), Ink()), *ramp, (duration(last_s), Ink())]
    if raster.landmarks is not None and raster.ground is Ground.UNCERTAINTY:
        return [("sd 0", Ink()), *ramp, (f"{raster.landmarks.most_shown_sd_m:g} m", Ink())]
    return [(f"{raster.lowest_m:.0f}", Ink()), *ramp, (f"{raster.highest_m:.0f} m", Ink())]


def _ends_ms(raster: Raster) -> tuple[int, int]:
    return (raster.first_ms, raster.last_ms)


def _ground_codes(raster: Raster, steps: int, window: MapWindow) -> np.ndarray[tuple[int, int], np.dtype[np.int64]]:
    """Per pixel: 0 outside, 1 unobserved, 2 frontier, 3 and on for observed ground."""
    kind = raster.kind
    if Layer.FRONTIERS not in window.layers:
        kind = np.where(kind == FRONTIER, OBSERVED, kind)
    if raster.ground is Ground.SEEN_BY:
        codes = 3 + np.maximum(raster.seen_by, 0).astype(np.int64) % steps
    elif raster.ground is Ground.OBSERVED:
        codes = np.full(kind.shape, 3 + steps // 2, dtype=np.int64)
    else:
        codes = 3 + np.minimum((raster.height_share * steps).astype(np.int64), steps - 1)
    ground: np.ndarray[tuple[int, int], np.dtype[np.int64]] = np.where(
        kind == OBSERVED, codes, np.where(kind == FRONTIER, 2, kind)
    )
    return ground


def _ground_colours(raster: Raster, window: MapWindow) -> Pixels:
    ramp = palette.cividis(RAMP_STEPS)
    if raster.ground is Ground.SEEN_BY:
        ramp = tuple(palette.blend(palette.UNOBSERVED, colour, 0.6) for colour in palette.VEHICLE_COLOURS)
    table: list[Rgb | None] = [None, palette.UNOBSERVED, palette.FRONTIER, *ramp]
    return [[table[code] for code in row] for row in _ground_codes(raster, len(ramp), window).T.tolist()]


def _draw_zones(zones: ZonePixels, pixels: Pixels) -> None:
    """Zones hatched, borders and the fence whole."""
    for (x, y), colour in zones.tints.items():
        ground = pixels[y][x]
        pixels[y][x] = palette.blend(ground or palette.UNOBSERVED, colour, 0.6)
    for (x, y), colour in zones.borders.items():
        pixels[y][x] = colour


def _draw_ways(state: FleetState, view: Viewport, pixels: Pixels, window: MapWindow) -> None:
    """Trails dim, reserved legs bright, the way beyond dotted."""
    for vehicle in state.vehicles:
        if vehicle.status is None:
            continue
        colour = palette.vehicle_colour(vehicle.index)
        trail = vehicle.trail_en_m[-TRAIL_POINTS:] if Layer.TRAILS in window.layers else ()
        for x, y in dict.fromkeys(line_pixels(trail, view)):
            ground = pixels[y][x]
            if ground is not None:
                pixels[y][x] = palette.blend(ground, colour, 0.3)
        if vehicle.condition in (Condition.LOST, Condition.LEFT) or Layer.PATHS not in window.layers:
            continue
        leg, path = _way(vehicle)
        for place, (x, y) in enumerate(line_pixels(path, view)):
            if place % 2 == 0:
                pixels[y][x] = colour
        for x, y in line_pixels(leg, view):
            pixels[y][x] = colour


def _way(vehicle: VehiclePicture) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """The reserved leg, and the planned way after it, as (east, north) corners."""
    assert vehicle.status is not None
    leg = [_plane(vehicle.status.position_cm), _plane(vehicle.status.leg_end_cm)]
    return leg, [leg[1], *(_plane(corner) for corner in vehicle.status.path_cm)]


def _plane(position_cm: PositionCm) -> tuple[float, float]:
    east_m, north_m, _ = metres(position_cm)
    return (east_m, north_m)


def _marks(state: FleetState, view: Viewport, look: Look, window: MapWindow, rows_per_character: int) -> Marks:
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
        shown = Layer.CLAIMS in window.layers
        if shown and claim is not None and claim.active and vehicle.condition in (Condition.LIVE, Condition.SUSPECT):
            ink = look.ink(palette.vehicle_colour(vehicle.index), palette.UNOBSERVED, bold=True)
            put(*_plane(claim.goal_cm), look.glyph("◇", "x"), ink)
    for vehicle in sorted(heard, key=lambda one: one.condition is Condition.LOST):
        position = vehicle.position_enu_m
        assert position is not None
        put(position[0], position[1], _vehicle_text(vehicle, look), _vehicle_ink(vehicle, look))
    corner = look.ink(palette.WARN, palette.UNOBSERVED, bold=True)
    for place, (east_m, north_m) in enumerate(window.drawn_en_m):
        put(east_m, north_m, str((place + 1) % 10), corner)
    if window.cursor_en_m is not None:
        cursor = Ink((0, 0, 0), palette.FRONTIER, bold=True) if look.colour else Ink(bold=True, reverse=True)
        put(*window.cursor_en_m, look.glyph("┼", "+"), cursor)
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


@lru_cache(maxsize=1024)
def _block_line(
    upper: tuple[Rgb | None, ...], lower: tuple[Rgb | None, ...], marks_by_x: tuple[tuple[int, Span], ...]
) -> Line:
    """One line of characters from two rows of pixels; equal neighbours share a span. Most rows are as they were."""
    marks = dict(marks_by_x)
    spans: list[Span] = []
    for x, (top, bottom) in enumerate(zip(upper, lower, strict=True)):
        mark = marks.get(x)
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


def _character_lines(
    state: FleetState, raster: Raster, view: Viewport, marks: Marks, zones: ZonePixels, look: Look, window: MapWindow
) -> list[Line]:
    """The map in plain characters: `.` unobserved, `~` frontier, a ramp for height, `:` way, `/` and `#` zones."""
    ramp = "123456789" if raster.ground is Ground.SEEN_BY else ASCII_RAMP
    table = " .~" + ramp
    codes = _ground_codes(raster, len(ramp), window)
    rows = [[(table[code], _character_ink(code, look)) for code in row] for row in codes.T.tolist()]
    for (x, y), colour in zones.tints.items():
        rows[y][x] = ("/", look.ink(colour))
    for (x, y), colour in zones.borders.items():
        rows[y][x] = ("#", look.ink(colour, bold=True))
    for vehicle in state.vehicles:
        hidden = vehicle.condition in (Condition.LOST, Condition.LEFT) or Layer.PATHS not in window.layers
        if vehicle.status is None or hidden:
            continue
        ink = look.ink(palette.vehicle_colour(vehicle.index), bold=True)
        leg, path = _way(vehicle)
        for x, y in [*line_pixels(path, view), *line_pixels(leg, view)]:
            rows[y][x] = (":", ink)
    for (x, y), mark in marks.items():
        rows[y][x] = mark
    return [_joined(row) for row in rows]


def _character_ink(code: int, look: Look) -> Ink:
    if not look.colour:
        return Ink(dim=code == 1)
    if code == 2:
        return Ink(palette.FRONTIER)
    ramp = palette.cividis(len(ASCII_RAMP))
    return Ink(palette.QUIET, dim=True) if code < 2 else Ink(ramp[(code - 3) % len(ramp)])


def _joined(spans: list[Span]) -> Line:
    joined: list[Span] = []
    for text, ink in spans:
        if joined and joined[-1][1] == ink:
            joined[-1] = (joined[-1][0] + text, ink)
        else:
            joined.append((text, ink))
    return tuple(joined)
