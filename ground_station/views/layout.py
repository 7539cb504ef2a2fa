"""How the dashboard shares a terminal between its panes."""

from __future__ import annotations

from dataclasses import dataclass

from vehicle_agent.domain.grid import Grid

MIN_WIDTH, MIN_HEIGHT = 60, 20
RIGHT_WIDTH = 43
"""Columns that a roster line needs."""
MIN_EVENT_LINES = 8
FIXED_LINES = 3
"""Header, banner, keys."""


@dataclass(frozen=True, slots=True)
class Layout:
    """Sizes in characters; the map and the events take what is left."""

    left_width: int
    curve_height: int
    roster_height: int


def arrange(grid: Grid, vehicles: int, width: int, height: int) -> Layout:
    """Give the map the width that its area can use, never so much that the roster is cut."""
    body = height - FIXED_LINES
    curve_height = 4 if body < 24 else max(5, body // 5)
    map_height = body - curve_height - 1
    aspect = (grid.east_m - grid.west_m) / (grid.north_m - grid.south_m)
    useful = round(2 * map_height * aspect) + 1  # a character is as high as two are wide
    left_width = max(16, min(useful, width - RIGHT_WIDTH))
    lines_each = 3 if body - (3 * vehicles + 1) >= MIN_EVENT_LINES else 2
    roster_height = max(3, min(lines_each * vehicles + 1, body - 5))
    return Layout(left_width, curve_height, roster_height)
