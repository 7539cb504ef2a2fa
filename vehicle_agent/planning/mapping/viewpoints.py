"""Work sites: landmarks gathered in square cells, what is left to do in each, and from where it is best done.

Compiled kernels over all landmarks of a cell at once; only cells whose landmarks changed are looked at again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.landmark_layout import LandmarkLayout
from vehicle_agent.domain.polygon import BoolArray


@dataclass(frozen=True, slots=True)
class SiteLattice:
    """Landmarks sorted into square cells.

    Attributes
    ----------
    west_m, south_m, cell_m
        South-western corner and edge of the cells.
    columns, rows
        Number of cells along east and north; cell `column * rows + row`.
    home
        (N,) int64, the cell of each landmark.
    order, first
        Landmarks by cell: those of cell c are `order[first[c]:first[c + 1]]`.
    """

    west_m: float
    south_m: float
    cell_m: float
    columns: int
    rows: int
    home: IndexArray
    order: IndexArray
    first: IndexArray

    @classmethod
    def over(cls, layout: LandmarkLayout, cell_m: float) -> SiteLattice:
        """Cells of about this edge around all landmarks."""
        low = layout.positions_en_m.min(axis=0) - 0.5 * layout.spacing_m
        extent = layout.positions_en_m.max(axis=0) + 0.5 * layout.spacing_m - low
        columns, rows = (max(1, math.ceil(side / cell_m - 1e-9)) for side in extent)
        edge = float(max(extent[0] / columns, extent[1] / rows))
        at = np.clip(((layout.positions_en_m - low) / edge).astype(np.int64), 0, [columns - 1, rows - 1])
        home = at[:, 0] * rows + at[:, 1]
        order = np.argsort(home, kind="stable")
        first = np.searchsorted(home[order], np.arange(columns * rows + 1))
        return cls(float(low[0]), float(low[1]), edge, columns, rows, home, order, first.astype(np.int64))

    @property
    def sites(self) -> int:
        return self.columns * self.rows

    def cell_of(self, east_m: float, north_m: float) -> int:
        """The cell that holds a point, or the border cell nearest to it."""
        column = min(max(int((east_m - self.west_m) / self.cell_m), 0), self.columns - 1)
        row = min(max(int((north_m - self.south_m) / self.cell_m), 0), self.rows - 1)
        return column * self.rows + row


@compiled
def cell_surfaces(
    first: IndexArray, order: IndexArray, heights: FloatArray, tops: FloatArray, means: FloatArray
) -> None:
    """Highest and mean estimated height of each cell's landmarks; NaN where none is known."""
    for cell in range(len(first) - 1):
        total, count, top = 0.0, 0, -math.inf
        for k in range(first[cell], first[cell + 1]):
            height = heights[order[k]]
            if not math.isnan(height):
                total += height
                count += 1
                top = max(top, height)
        means[cell] = total / count if count else math.nan
        tops[cell] = top if count else math.nan


@compiled
def fill_unknown(values: FloatArray, columns: int, rows: int) -> None:
    """Give cells without a value the mean of their neighbours that have one, outwards from those; 0 if none has."""
    waiting = np.empty(len(values), dtype=np.int64)
    count = 0
    for cell in range(len(values)):
        if not math.isnan(values[cell]):
            waiting[count] = cell
            count += 1
    if count == 0:
        values[:] = 0.0
        return
    at = 0
    while at < count < len(values):
        column, row = waiting[at] // rows, waiting[at] % rows
        at += 1
        for i in range(max(0, column - 1), min(columns, column + 2)):
            for j in range(max(0, row - 1), min(rows, row + 2)):
                cell = i * rows + j
                if not math.isnan(values[cell]):
                    continue
                total, known = 0.0, 0
                for k in range(max(0, i - 1), min(columns, i + 2)):
                    for m in range(max(0, j - 1), min(rows, j + 2)):
                        value = values[k * rows + m]
                        if not math.isnan(value):
                            total += value
                            known += 1
                values[cell] = total / known
                waiting[count] = cell
                count += 1


@compiled
def open_near(places: FloatArray, open_: BoolArray, east_m: float, north_m: float, reach_m: float) -> IndexArray:
    """Open landmarks not farther than this to the east, west, north or south."""
    near = np.empty(len(places), dtype=np.int64)
    count = 0
    for landmark in range(len(places)):
        if (
            open_[landmark]
            and abs(places[landmark, 0] - east_m) <= reach_m
            and abs(places[landmark, 1] - north_m) <= reach_m
        ):
            near[count] = landmark
            count += 1
    return near[:count].copy()


@compiled
def best_first_visit(
    sites: IndexArray, viewpoints: FloatArray, visits: FloatArray, values: FloatArray, here: FloatArray,
    reach_m: float, horizon: float, depth: int, choices: int, present: int,
) -> int:  # fmt: skip
    """Of some sites the one from which the best sequence of visits starts.

    A sequence goes on, from each site, to the one whose work, discounted by the time until it is done, is greatest.
    Sequences are tried from the sites of most work per time, and from the present goal, which is given up only for one
    that is a tenth better.
    """
    count = len(sites)
    rates = np.empty(count)
    for n in range(count):
        rates[n] = values[sites[n]] / (_away(viewpoints[sites[n]], here) / reach_m + visits[sites[n]])
    order = np.argsort(-rates)
    best, chosen = -1.0, sites[order[0]]
    done = np.zeros(count, dtype=np.bool_)
    for n in range(count):
        if n >= choices and sites[order[n]] != present:
            continue
        done[:] = False
        row, place, elapsed, total = order[n], here, 0.0, 0.0
        for _ in range(depth):
            site = sites[row]
            elapsed += _away(viewpoints[site], place) / reach_m + visits[site]
            total += values[site] * math.exp(-elapsed / horizon)
            done[row] = True
            place = viewpoints[site]
            row, most = -1, 0.0
            for k in range(count):
                if not done[k]:
                    way = _away(viewpoints[sites[k]], place) / reach_m + visits[sites[k]]
                    value = values[sites[k]] * math.exp(-way / horizon)
                    if value > most:
                        row, most = k, value
            if row < 0:
                break
        if sites[order[n]] == present:
            total *= 1.1
        if total > best:
            best, chosen = total, sites[order[n]]
    return int(chosen)


@compiled
def _away(a: FloatArray, b: FloatArray) -> float:
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@compiled
def told(
    away_squared: float, drop: float, precision: float, best: float, range_squared: float, footprint_squared: float
) -> float:
    """What one measurement tells of a landmark (1 makes it accurate): `expected_information` for one."""
    squared = away_squared + drop * drop
    if drop <= 0.0 or squared >= range_squared or away_squared > footprint_squared:
        return 0.0
    share = precision * drop / squared
    return min(share * share, best)


@compiled
def plan_sites(
    cells: IndexArray, first: IndexArray, order: IndexArray, places: FloatArray, supposed: FloatArray,
    information: FloatArray, open_: BoolArray, band: FloatArray, sensor: FloatArray,
    heights_tried: IndexArray, viewpoints: FloatArray, work: FloatArray, visits: FloatArray,
) -> None:  # fmt: skip
    """For some cells: where their open landmarks are best seen from, how much is left, and how many steps that takes.

    Parameters
    ----------
    places, supposed : (N, 2) and (N,), where landmarks are supposed to be.
    information, open_ : (N,), what is known of each and whether it is worth more.
    band : clearance, lowest and highest allowed height.
    sensor : precision, best single measurement, squared range, squared footprint.
    heights_tried : indices 0, 1, 2, ... of heights, in parts of the sensor's range.
    viewpoints, work, visits : (cells, 3), (cells,), (cells,), written for the cells given.
    """
    clearance, lowest, highest = band[0], band[1], band[2]
    precision, best, range_squared, footprint_squared = sensor[0], sensor[1], sensor[2], sensor[3]
    reach = math.sqrt(range_squared)
    for n in range(len(cells)):
        cell = cells[n]
        east = north = base = left = 0.0
        count = 0
        for k in range(first[cell], first[cell + 1]):
            landmark = order[k]
            if open_[landmark]:
                rest = 1.0 - min(information[landmark], 0.9)
                east += rest * places[landmark, 0]
                north += rest * places[landmark, 1]
                base += rest * supposed[landmark]
                left += rest
                count += 1
        work[cell] = count
        if count == 0:
            continue
        east /= left
        north /= left
        base /= left
        viewpoints[cell, 0], viewpoints[cell, 1] = east, north
        best_rate = -1.0
        for option in heights_tried:
            up = min(max(base + clearance + 0.12 * option * reach, lowest), highest)
            steps, gained = 0.0, 0.0
            for k in range(first[cell], first[cell + 1]):
                landmark = order[k]
                if not open_[landmark]:
                    continue
                away = (places[landmark, 0] - east) ** 2 + (places[landmark, 1] - north) ** 2
                gain = told(away, up - supposed[landmark], precision, best, range_squared, max(footprint_squared, away))
                need = 1.0 - min(information[landmark], 0.95)
                gained += min(2.0 * gain, need) / need
                steps += min(need / max(gain, 1e-3), 12.0)
            rate = gained / (1.0 + steps / count)
            if rate > best_rate:
                best_rate = rate
                viewpoints[cell, 2] = up
                visits[cell] = max(1.0, steps / count)


@compiled
def immediate_gains(
    ends: FloatArray, near: IndexArray, places: FloatArray, supposed: FloatArray, information: FloatArray,
    trust: FloatArray, sensor: FloatArray, gains: FloatArray,
) -> None:  # fmt: skip
    """What measuring once at each of some ends would add to the open landmarks `near`, each as far as trusted."""
    precision, best, range_squared, footprint_squared = sensor[0], sensor[1], sensor[2], sensor[3]
    for n in range(len(ends)):
        total = 0.0
        for k in range(len(near)):
            landmark = near[k]
            away = (places[landmark, 0] - ends[n, 0]) ** 2 + (places[landmark, 1] - ends[n, 1]) ** 2
            gain = told(away, ends[n, 2] - supposed[landmark], precision, best, range_squared, footprint_squared)
            total += trust[landmark] * min(gain, 1.0 - information[landmark])
        gains[n] = total


@compiled
def distances_to(goal: int, heights: FloatArray, columns: int, rows: int, cell_m: float) -> FloatArray:
    """Length of the shortest way from every cell to one of them over a surface, by the eight neighbours: (cells,)."""
    distances = np.full(len(heights), math.inf)
    distances[goal] = 0.0
    for sweep in range(4 * max(columns, rows)):
        changed = False
        for a in range(columns):
            column = a if sweep % 2 == 0 else columns - 1 - a
            for b in range(rows):
                row = b if sweep // 2 % 2 == 0 else rows - 1 - b
                cell = column * rows + row
                least = distances[cell]
                for i in range(max(0, column - 1), min(columns, column + 2)):
                    for j in range(max(0, row - 1), min(rows, row + 2)):
                        other = i * rows + j
                        if distances[other] >= least:
                            continue
                        flat = cell_m * cell_m * ((i - column) ** 2 + (j - row) ** 2)
                        way = distances[other] + math.sqrt(flat + (heights[other] - heights[cell]) ** 2)
                        if way < least - 1e-12:
                            least = way
                            changed = True
                distances[cell] = least
        if not changed and sweep >= 3:
            break
    return distances


@compiled
def interpolated(
    values: FloatArray, points: FloatArray, west_m: float, south_m: float, cell_m: float, columns: int, rows: int
) -> FloatArray:
    """Values of cells between their centres, bilinearly: (cells,) and (N, 2 or 3) -> (N,)."""
    result = np.empty(len(points))
    for n in range(len(points)):
        u = min(max((points[n, 0] - west_m) / cell_m - 0.5, 0.0), columns - 1.0)
        v = min(max((points[n, 1] - south_m) / cell_m - 0.5, 0.0), rows - 1.0)
        i, j = min(int(u), max(columns - 2, 0)), min(int(v), max(rows - 2, 0))
        p, q = u - i, v - j
        k, m = min(i + 1, columns - 1), min(j + 1, rows - 1)
        low = (1.0 - p) * values[i * rows + j] + p * values[k * rows + j]
        high = (1.0 - p) * values[i * rows + m] + p * values[k * rows + m]
        result[n] = (1.0 - q) * low + q * high
    return result
