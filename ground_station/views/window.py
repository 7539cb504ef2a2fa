"""What the operator looks at on the map: zoom, place, layers, cursor, and the corners being drawn. Pure values."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

from ground_station.picture import FleetState
from ground_station.views.viewport import Viewport
from vehicle_agent.domain.grid import Grid

ZOOM_STEP = 1.5
MAX_ZOOM = 16
PAN_SHARE = 0.25


class Ground(Enum):
    """What the colours of the ground mean."""

    ELEVATION = "elevation"
    OBSERVED = "observed"
    SEEN_BY = "seen first by"
    SEEN_WHEN = "seen when"
    UNCERTAINTY = "uncertainty of heights"
    BELIEF = "search belief"


class Layer(Enum):
    """What lies over the ground."""

    FRONTIERS = "frontiers"
    CLAIMS = "claims (goals)"
    PATHS = "planned paths"
    TRAILS = "trails"
    NO_FLY = "no-fly zones"
    FENCE = "fence"


EastNorth = tuple[float, float]
SHOWN_AT_FIRST = frozenset(Layer) - {Layer.FENCE}


@dataclass(frozen=True, slots=True)
class MapWindow:
    """How the map is looked at.

    Attributes
    ----------
    zoom
        Steps of `ZOOM_STEP` beyond the whole area.
    centre_en_m
        Middle of the view; None: of the area.
    follow
        Vehicle that the view follows; empty for none.
    ground, layers
        What is drawn.
    cursor_en_m
        Where the cursor stands; None when it is hidden.
    drawn_en_m
        Corners of the polygon being drawn.
    """

    zoom: int = 0
    centre_en_m: EastNorth | None = None
    follow: str = ""
    ground: Ground = Ground.ELEVATION
    layers: frozenset[Layer] = SHOWN_AT_FIRST
    cursor_en_m: EastNorth | None = None
    drawn_en_m: tuple[EastNorth, ...] = ()

    def viewport(self, grid: Grid, width: int, height: int, pixel_aspect: float = 1.0) -> Viewport:
        """The view of this window; arguments as `Viewport.around`."""
        whole = Viewport.around(grid, width, height, pixel_aspect)
        scale = ZOOM_STEP**-self.zoom
        pixel_width_m, pixel_height_m = whole.pixel_width_m * scale, whole.pixel_height_m * scale
        middle = ((grid.west_m + grid.east_m) / 2, (grid.south_m + grid.north_m) / 2)
        east_m, north_m = middle if self.zoom == 0 or self.centre_en_m is None else self.centre_en_m
        west_m, top_m = east_m - width * pixel_width_m / 2, north_m + height * pixel_height_m / 2
        return Viewport(west_m, top_m, pixel_width_m, pixel_height_m, width, height)

    def zoomed(self, steps: int, grid: Grid) -> MapWindow:
        """In (positive) or out; at the first step in, about the cursor."""
        zoom = min(MAX_ZOOM, max(0, self.zoom + steps))
        if zoom == 0:
            return replace(self, zoom=0, centre_en_m=None)
        centre = self.centre_en_m or self.cursor_en_m
        return replace(self, zoom=zoom, centre_en_m=_inside(centre, grid) if centre else None)

    def panned(self, east: int, north: int, view: Viewport, grid: Grid) -> MapWindow:
        """Moved by quarters of the view; it no longer follows."""
        if self.zoom == 0:
            return self
        centre = (
            view.west_m + (0.5 + PAN_SHARE * east) * view.width * view.pixel_width_m,
            view.north_m - (0.5 - PAN_SHARE * north) * view.height * view.pixel_height_m,
        )
        return replace(self, centre_en_m=_inside(centre, grid), follow="")

    def with_cursor_moved(self, east: int, north: int, view: Viewport, grid: Grid, rows_per_step: int) -> MapWindow:
        """The cursor moved by characters; the view moves along where it would be left."""
        start = self.cursor_en_m or (
            view.west_m + view.width * view.pixel_width_m / 2,
            view.north_m - view.height * view.pixel_height_m / 2,
        )
        cursor = _inside(
            (start[0] + east * view.pixel_width_m, start[1] + north * rows_per_step * view.pixel_height_m), grid
        )
        moved = replace(self, cursor_en_m=cursor)
        if self.zoom and not view.holds(*view.pixel_of(*cursor)):
            return replace(moved, centre_en_m=cursor, follow="")
        return moved

    def following(self, state: FleetState, view: Viewport) -> MapWindow:
        """Centred anew on the followed vehicle, once it has left the middle half of the view."""
        vehicle = next((one for one in state.vehicles if one.name == self.follow), None)
        position = vehicle.position_enu_m if vehicle is not None else None
        if position is None or self.zoom == 0:
            return self
        x, y = view.pixel_of(position[0], position[1])
        if abs(x - view.width / 2) <= view.width / 4 and abs(y - view.height / 2) <= view.height / 4:
            return self
        return replace(self, centre_en_m=position[:2])

    def toggled(self, layer: Layer) -> MapWindow:
        return replace(self, layers=self.layers ^ {layer})

    def with_next_ground(self) -> MapWindow:
        kinds = list(Ground)
        return replace(self, ground=kinds[(kinds.index(self.ground) + 1) % len(kinds)])


def scale_bar(metres_per_character: float, longest: int) -> tuple[int, str]:
    """Length in characters, at most `longest`, and label of a bar of 1, 2 or 5 times a power of ten metres."""
    most_m = metres_per_character * longest
    power = 10.0 ** math.floor(math.log10(max(most_m, 0.01)))
    length_m = next((step * power for step in (5.0, 2.0, 1.0) if step * power <= most_m), power)
    label = f"{length_m / 1_000:g} km" if length_m >= 1_000 else f"{length_m:g} m"
    return max(1, round(length_m / metres_per_character)), label


def _inside(place: EastNorth, grid: Grid) -> EastNorth:
    east_m, north_m = place
    return (
        min(max(east_m, grid.west_m), grid.east_m - 1e-6),
        min(max(north_m, grid.south_m), grid.north_m - 1e-6),
    )
