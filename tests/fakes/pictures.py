"""Comparing what stations know."""

from __future__ import annotations

import dataclasses

import numpy as np

from ground_station.picture import FleetState


def same_picture(one: FleetState, other: FleetState) -> bool:
    """Equal in every field; plans and maps by their content."""
    for field in dataclasses.fields(FleetState):
        mine, theirs = getattr(one, field.name), getattr(other, field.name)
        if field.name == "plan":
            equal = mine.mission == theirs.mission and mine.grid == theirs.grid
        elif field.name == "team_map":
            equal = mine.elevation == theirs.elevation and np.array_equal(mine.area, theirs.area)
            rest = [f.name for f in dataclasses.fields(mine) if f.name not in ("elevation", "area")]
            equal = equal and all(getattr(mine, name) == getattr(theirs, name) for name in rest)
        else:
            equal = mine == theirs
        if not equal:
            return False
    return True
