"""The coverage curve over vehicle time, in braille dots or ASCII, with its numbers."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ground_station.picture import FleetState
from ground_station.team_map import coverage_curve
from ground_station.text import duration
from ground_station.views import palette
from ground_station.views.ink import Line, Look, Span, line_of

Curves = npt.NDArray[np.float64]
"""(vehicles, 2 x columns) shares of the area seen first, see `team_map.contribution_curves`."""
RATE_WINDOW_S = 60.0
_BRAILLE_DOTS = ((0x40, 0x04, 0x02, 0x01), (0x80, 0x20, 0x10, 0x08))
"""Bits of a braille cell: [column][row from below]."""


def curve_lines(state: FleetState, width: int, height: int, look: Look, by_vehicle: Curves | None = None) -> list[Line]:
    """A title with the numbers, the filled curve from 0 to 100 %, and the time under it.

    Parameters
    ----------
    by_vehicle
        Every vehicle's part of the area instead of the team's, from 0 to the largest.
    """
    plot_width, plot_height = width - 5, height - 2
    if plot_width < 8 or plot_height < 1:
        return [_title(state, look)]
    if by_vehicle is not None:
        return _contribution_lines(state, by_vehicle, plot_width, plot_height, look)
    title = _title(state, look)
    shares = _resampled(coverage_curve(state.team_map, state.started_ms), state.elapsed_s, 2 * plot_width)
    dots = [round(share * 4 * plot_height) for share in shares]
    lines = [title]
    for row in range(plot_height):
        label = "100%" if row == 0 else "  0%" if row == plot_height - 1 else "    "
        floor = 4 * (plot_height - 1 - row)
        text = "".join(
            _character(dots[2 * x] - floor, dots[2 * x + 1] - floor, look) if dots else " " for x in range(plot_width)
        )
        lines.append(line_of((label + " ", look.ink(palette.QUIET)), (text, look.ink(palette.ACCENT))))
    end = duration(state.elapsed_s)
    lines.append(line_of((f"     0:00:00{end:>{max(1, plot_width - 7)}}", look.ink(palette.QUIET))))
    return lines


def _contribution_lines(state: FleetState, curves: Curves, width: int, height: int, look: Look) -> list[Line]:
    """One line of dots per vehicle, in its colour; where two meet, the better one is seen."""
    top = max(0.01, float(curves.max()) if curves.size else 0.0)
    rows: list[list[Span]] = [[(" ", look.ink())] * width for _ in range(height)]
    by_merit = sorted(state.vehicles, key=lambda vehicle: curves[vehicle.index, -1])
    for vehicle in by_merit:
        ink = look.ink(palette.vehicle_colour(vehicle.index), bold=True)
        dots = np.minimum(4 * height - 1, (curves[vehicle.index] / top * (4 * height - 1)).round().astype(np.int64))
        for x in range(width):
            left, right = int(dots[2 * x]), int(dots[2 * x + 1])
            row = height - 1 - max(left, right) // 4
            if look.unicode:
                bits = _BRAILLE_DOTS[0][left % 4] if left // 4 == height - 1 - row else 0
                bits |= _BRAILLE_DOTS[1][right % 4] if right // 4 == height - 1 - row else 0
                rows[row][x] = (chr(0x2800 + bits), ink)
            else:
                rows[row][x] = (str((vehicle.index + 1) % 10), ink)
    best = by_merit[-1]
    title = line_of(
        ("seen first: ", look.ink(palette.QUIET)),
        (f"{best.name} {100 * state.team_map.first_seen_share(best.index):.1f}%", look.ink(bold=True)),
    )
    lines = [title]
    for at, row_spans in enumerate(rows):
        label = f"{100 * top:3.0f}% " if at == 0 else "  0% " if at == height - 1 else "     "
        lines.append(((label, look.ink(palette.QUIET)), *row_spans))
    lines.append(line_of((f"     0:00:00{duration(state.elapsed_s):>{max(1, width - 7)}}", look.ink(palette.QUIET))))
    return lines


def _title(state: FleetState, look: Look) -> Line:
    quiet = look.ink(palette.QUIET)
    rate = _rate_per_min(state)
    drawn = state.landmarks.drawn if state.landmarks is not None else None
    return line_of(
        ("coverage ", quiet),
        (f"{100 * state.coverage:.1f}%", look.ink(palette.ACCENT, bold=True)),
        (f"  {rate:+.1f}%/min" if rate is not None else "", quiet),
        (f"  ±{drawn.typical_sd_m():.2f} m" if drawn is not None else "", quiet),
    )


def _rate_per_min(state: FleetState) -> float | None:
    """Percent of the area per minute of vehicle time, over the last minute; None before a quarter of it."""
    span_s = min(RATE_WINDOW_S, state.elapsed_s)
    if span_s < RATE_WINDOW_S / 4:
        return None
    since_s = state.newest_ms / 1_000 - span_s
    recent = sum(count for second, count in state.team_map.seen_per_second.items() if second >= since_s)
    return 100 * recent / max(1, state.team_map.area_cells) * 60 / span_s


def _resampled(curve: tuple[tuple[float, float], ...], until_s: float, columns: int) -> list[float]:
    """The share at `columns` moments evenly over 0 .. `until_s`."""
    if not curve:
        return []
    shares: list[float] = []
    at = 0
    for column in range(columns):
        moment_s = until_s * (column + 1) / columns
        while at < len(curve) and curve[at][0] <= moment_s:
            at += 1
        shares.append(curve[at - 1][1] if at else 0.0)
    shares[-1] = curve[-1][1]
    return shares


def _character(left: int, right: int, look: Look) -> str:
    """A filled character of two columns of up to four dots each."""
    if not look.unicode:
        return " .:#"[max(0, min(3, (max(left, right) + 1) // 2))] if max(left, right) < 4 else "#"
    bits = 0
    for column, height in enumerate((left, right)):
        for row in range(max(0, min(4, height))):
            bits |= _BRAILLE_DOTS[column][row]
    return chr(0x2800 + bits) if bits else " "
