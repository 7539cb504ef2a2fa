"""A map version as pixels: what is outside, unobserved, frontier, and how high the observed ground is."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ground_station.landmark_picture import LandmarkPicture
from ground_station.team_map import TeamMap, frontier_cells
from ground_station.views.viewport import Viewport
from ground_station.views.window import Ground
from vehicle_agent.domain.frames import FloatArray

NEEDS_TELLING = (Ground.UNCERTAINTY, Ground.BELIEF)
DRAWN_BETWEEN = (Ground.ELEVATION, Ground.UNCERTAINTY)
"""Grounds that show a surface between landmarks too."""
"""What only some kinds of mission tell; the caption says so where it is missing."""
OUTSIDE, UNOBSERVED, OBSERVED, FRONTIER = range(4)
RAMP_ROUNDING_M = 50.0
"""Ends of the colour ramp are multiples of this, so that new ground seldom recolours the whole map."""


@dataclass(frozen=True, slots=True, eq=False)
class Raster:
    """What a map version looks like in a view.

    Attributes
    ----------
    version, view
        Of which map, and from where.
    kind
        (width, height) uint8: OUTSIDE, UNOBSERVED, OBSERVED or FRONTIER.
    height_share
        (width, height) float64, place of the observed ground between `low_m` and `high_m`, or of its first observation
        between the map's first and last when `ground` is SEEN_WHEN, or of its uncertainty between none and the most
        that is shown when it is UNCERTAINTY, in [0, 1]; 0 elsewhere.
    low_m, high_m
        Ends of the ramp, ENU metres.
    lowest_m, highest_m
        Of the observed ground; 0 before any.
    ground
        What `height_share` means.
    seen_by
        (width, height) int16, team index of a first observer of each pixel's middle; -1 where there is none, and
        everywhere unless `ground` is SEEN_BY.
    first_ms, last_ms
        Stamps of the map's first and last first observation.
    landmarks
        Of which landmarks; None where there are none.
    """

    version: int
    view: Viewport
    kind: npt.NDArray[np.uint8]
    height_share: FloatArray
    low_m: float
    high_m: float
    lowest_m: float
    highest_m: float
    ground: Ground
    seen_by: npt.NDArray[np.int16]
    first_ms: int
    last_ms: int
    landmarks: LandmarkPicture | None


def rasterise(
    team_map: TeamMap,
    view: Viewport,
    ground: Ground = Ground.ELEVATION,
    landmarks: LandmarkPicture | None = None,
) -> Raster:
    """Sum the map's cells into the view's pixels (or sample them where pixels are smaller than cells)."""
    grid = team_map.elevation.grid
    observed = team_map.elevation.observed & team_map.area
    heights_m = np.where(observed, team_map.elevation.elevation_dm * 0.1, 0.0)
    seen, seen_dm = observed, team_map.elevation.elevation_dm[observed]
    drawn = landmarks.drawn if landmarks is not None and ground in DRAWN_BETWEEN else None
    if landmarks is not None and drawn is not None:
        between = team_map.area & ~observed & (drawn.sd_m < landmarks.most_shown_sd_m)
        heights_m, observed = np.where(between, drawn.elevation_m, heights_m), observed | between
    frontier = frontier_cells(team_map)
    if min(view.pixel_width_m, view.pixel_height_m) < grid.cell_m:
        layers = [_sampled(layer.astype(np.float64), team_map, view) for layer in (team_map.area, observed, frontier)]
        height_sums = _sampled(heights_m, team_map, view)
    else:
        layers = [_summed(layer.astype(np.float64), team_map, view) for layer in (team_map.area, observed, frontier)]
        height_sums = _summed(heights_m, team_map, view)
    area_sums, observed_sums, frontier_sums = layers
    kind = np.full((view.width, view.height), OUTSIDE, dtype=np.uint8)
    kind[area_sums > 0] = UNOBSERVED
    kind[(observed_sums > 0) & (observed_sums >= 0.5 * area_sums)] = OBSERVED
    if landmarks is None:  # soundings are scattered: a map of landmarks has no edge to explore
        kind[frontier_sums > 0] = FRONTIER
    lowest_m, highest_m = (float(seen_dm.min()) / 10, float(seen_dm.max()) / 10) if len(seen_dm) else (0.0, 0.0)
    low_m = math.floor(lowest_m / RAMP_ROUNDING_M) * RAMP_ROUNDING_M
    high_m = max(math.ceil(highest_m / RAMP_ROUNDING_M) * RAMP_ROUNDING_M, low_m + RAMP_ROUNDING_M)
    mean_m = height_sums / np.maximum(observed_sums, 1.0)
    share = np.where(observed_sums > 0, np.clip((mean_m - low_m) / (high_m - low_m), 0.0, 1.0), 0.0)
    stamps_ms = team_map.elevation.first_stamp_ms
    first_ms, last_ms = (int(stamps_ms[seen].min()), int(stamps_ms[seen].max())) if len(seen_dm) else (0, 0)
    if ground is Ground.SEEN_WHEN:
        ages = np.where(observed, (stamps_ms - first_ms) / max(1, last_ms - first_ms), 0.0)
        share = np.clip(_sampled(ages, team_map, view), 0.0, 1.0)
    if ground in NEEDS_TELLING:
        share = np.zeros_like(share)
    if ground is Ground.UNCERTAINTY and landmarks is not None:
        sd_m = landmarks.sd_m
        if drawn is not None:
            sd_m = np.minimum(sd_m, drawn.sd_m)  # a landmark is better known by its neighbours than by itself
        share = _sampled(np.minimum(1.0, sd_m / landmarks.most_shown_sd_m), team_map, view)
    seen_by = np.full((view.width, view.height), -1, dtype=np.int16)
    if ground is Ground.SEEN_BY:
        seen_by = (_sampled(_lowest_bits(team_map.elevation.observers) + 1.0, team_map, view) - 1.0).astype(np.int16)
    return Raster(
        team_map.version,
        view,
        kind,
        share,
        low_m,
        high_m,
        lowest_m,
        highest_m,
        ground,
        seen_by,
        first_ms,
        last_ms,
        landmarks,
    )


def _lowest_bits(words: npt.NDArray[np.uint64]) -> FloatArray:
    """Number of each word's lowest set bit; -1 for zero."""
    lowest = words & (~words + np.uint64(1))
    return np.where(words == 0, -1.0, np.log2(np.maximum(lowest, np.uint64(1)).astype(np.float64)))


def _summed(layer: FloatArray, team_map: TeamMap, view: Viewport) -> FloatArray:
    grid = team_map.elevation.grid
    x = np.floor((grid.centres_east_m() - view.west_m) / view.pixel_width_m).astype(np.int64)
    y = np.floor((view.north_m - grid.centres_north_m()) / view.pixel_height_m).astype(np.int64)
    inside = ((x >= 0) & (x < view.width))[:, None] & ((y >= 0) & (y < view.height))[None, :]
    flat = (x[:, None] * view.height + y[None, :])[inside]
    sums = np.bincount(flat, weights=layer[inside], minlength=view.width * view.height)
    return sums.astype(np.float64).reshape(view.width, view.height)


def _sampled(layer: FloatArray, team_map: TeamMap, view: Viewport) -> FloatArray:
    grid = team_map.elevation.grid
    east_m = view.west_m + (np.arange(view.width) + 0.5) * view.pixel_width_m
    north_m = view.north_m - (np.arange(view.height) + 0.5) * view.pixel_height_m
    columns = np.floor((east_m - grid.west_m) / grid.cell_m).astype(np.int64)
    rows = np.floor((north_m - grid.south_m) / grid.cell_m).astype(np.int64)
    inside = ((columns >= 0) & (columns < grid.columns))[:, None] & ((rows >= 0) & (rows < grid.rows))[None, :]
    taken = layer[np.clip(columns, 0, grid.columns - 1)][:, np.clip(rows, 0, grid.rows - 1)]
    sampled: FloatArray = np.where(inside, taken, 0.0)
    return sampled


def segment_pixels(start: tuple[int, int], end: tuple[int, int], view: Viewport) -> list[tuple[int, int]]:
    """Pixels of a straight line from `start` to `end` inside the view, in order."""
    steps = max(abs(end[0] - start[0]), abs(end[1] - start[1]))
    if steps == 0:
        return [start] if view.holds(*start) else []
    if steps > 8 * (view.width + view.height):  # far outside: an implausible position, not worth drawing
        return []
    pixels = (
        (round(start[0] + (end[0] - start[0]) * step / steps), round(start[1] + (end[1] - start[1]) * step / steps))
        for step in range(steps + 1)
    )
    return [pixel for pixel in pixels if view.holds(*pixel)]


def line_pixels(corners: Sequence[tuple[float, float]], view: Viewport) -> Iterator[tuple[int, int]]:
    """Pixels of a line through corners given as (east, north) in ENU metres; none twice in a row."""
    last: tuple[int, int] | None = None
    for east_m, north_m in corners:
        pixel = view.pixel_of(east_m, north_m)
        if pixel == last:
            continue
        if last is None:
            if len(corners) > 1 and view.holds(*pixel):
                yield pixel
        elif abs(pixel[0] - last[0]) <= 1 and abs(pixel[1] - last[1]) <= 1:
            if view.holds(*pixel):
                yield pixel
        else:
            yield from (one for one in segment_pixels(last, pixel, view) if one != last)
        last = pixel
