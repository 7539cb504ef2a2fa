"""What one vehicle knows of all work sites: how much is left to do at each, from where, and what ways to them cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.mapping.interface import MappingSituation
from vehicle_agent.planning.mapping.viewpoints import (
    SiteLattice,
    best_first_visit,
    cell_surfaces,
    distances_to,
    fill_unknown,
    immediate_gains,
    interpolated,
    open_near,
    plan_sites,
)

_DESCENT = 0.3
"""What height above the lowest flight costs, against length of the way."""
_TRUST_KEPT = 0.5
_TRUST_REGAINED = 0.01


@dataclass(frozen=True, slots=True)
class ViewpointParams:
    """How the planner weighs.

    Attributes
    ----------
    cell_share
        Edge of a work cell over the distance from which the sensor's one look makes a landmark accurate.
    horizon_steps
        Work that far ahead counts 1/e of work done at once.
    edge_bonus
        How much more a cell counts that is surrounded by finished ones, so that no islands are left.
    each_site
        What a cell counts beside its landmarks, in those of a full one: the way to come back to it later is as long
        for one landmark as for many.
    visits_ahead
        Sites looked ahead.
    choices
        Sites considered at each of them.
    elsewhere
        How much a cell in another group's part counts.
    theirs
        How much a landmark counts for the next leg that a teammate is nearer to, who will see to it.
    company
        How far a follower's goal may be from its leader's, over the radio range. Legs keep the link by themselves; a
        goal beyond it lets vehicles work side by side, each where its own looks suffice.
    """

    cell_share: float = 0.75
    horizon_steps: float = 15.0
    edge_bonus: float = 2.0
    each_site: float = 3.0
    visits_ahead: int = 4
    choices: int = 5
    elsewhere: float = 0.1
    theirs: float = 0.5
    company: float = 1.3


class WorkSites:
    """All work cells as one vehicle knows them."""

    def __init__(self, situation: MappingSituation, params: ViewpointParams, vehicles: int) -> None:
        known, sensor = situation.landmarks, situation.sensor
        self._params = params
        precision = known.params.accurate_sd_m / sensor.noise_share
        wide = min(params.cell_share * precision, 0.5 * sensor.range_m, 2.0 * sensor.footprint_m)
        self.lattice = SiteLattice.over(known.layout, max(wide, known.layout.spacing_m))
        extent = float(np.ptp(known.layout.positions_en_m, axis=0).max())
        self.terrain = SiteLattice.over(known.layout, max(situation.reach_m, known.layout.spacing_m, extent / 40.0))
        count = self.lattice.sites
        self.viewpoints: FloatArray = np.zeros((count, 3))
        self.work: FloatArray = np.zeros(count)
        self.visits: FloatArray = np.ones(count)
        self._places = np.ascontiguousarray(known.layout.positions_en_m)
        self._information: FloatArray = np.full(len(known.layout), -1.0)
        self._trust: FloatArray = np.ones(len(known.layout))
        self._expected: IndexArray = np.empty(0, np.int64)
        self._near: IndexArray = np.empty(0, np.int64)
        self._supposed: FloatArray = np.full(len(known.layout), np.nan)
        self._best = (known.params.accurate_sd_m / known.params.best_sd_m) ** 2
        self._sensor = np.array([precision, self._best, sensor.range_m**2, min(sensor.footprint_m, 1e150) ** 2])
        self._open = known.open
        self.preference = _parts(self.lattice, max(vehicles // 2, 1), params.elsewhere)
        keeps_height = situation.band.lowest_m == situation.band.highest_m
        self._heights = np.arange(1 if keeps_height else 6, dtype=np.int64)

    def update(self, situation: MappingSituation) -> None:
        """Look again at the cells whose landmarks have changed."""
        known = situation.landmarks
        information, self._open = known.information, known.open
        if situation.said_done is not None and np.any(self._open & ~situation.said_done):
            self._open &= ~situation.said_done
            information = np.where(situation.said_done, np.maximum(information, 1.0), information)
        changed = information != self._information
        self._learn(changed)
        touched = self.lattice.home[changed]
        if len(touched) == 0:
            return
        self._information = information
        lattice = self.lattice
        tops, means = np.empty(lattice.sites), np.empty(lattice.sites)
        cell_surfaces(lattice.first, lattice.order, known.heights_m, tops, means)
        fill_unknown(means, lattice.columns, lattice.rows)
        self._supposed = np.where(np.isnan(known.heights_m), means[lattice.home], known.heights_m)
        cells = _grown(np.unique(touched), lattice)
        band = situation.band
        plan_sites(
            cells, lattice.first, lattice.order, self._places, self._supposed, information, self._open,
            np.array([band.clearance_m, band.lowest_m, band.highest_m]),
            self._sensor, self._heights, self.viewpoints, self.work, self.visits,
        )  # fmt: skip

    def _learn(self, changed: BoolArray) -> None:
        """Expect less of landmarks that should have been measured and were not: something hides them from there."""
        self._trust += _TRUST_REGAINED * (1.0 - self._trust)
        self._trust[self._expected[~changed[self._expected]]] *= _TRUST_KEPT
        self._trust[changed] = 1.0

    def expect(self, end: FloatArray) -> None:
        """Remember what a look from the chosen end should tell something of."""
        near = self._near
        away = ((self._places[near] - end[:2]) ** 2).sum(axis=1)
        drop = end[2] - self._supposed[near]
        _, _, range_squared, footprint_squared = self._sensor
        self._expected = near[(drop > 0.0) & (away + drop**2 < range_squared) & (away <= footprint_squared)]

    def left_at(self, site: int) -> float:
        """What is left to measure at a site, in landmarks of which nothing is known."""
        lattice = self.lattice
        here = lattice.order[lattice.first[site] : lattice.first[site + 1]]
        return float((1.0 - self._information[here[self._open[here]]]).sum())

    def values(self) -> FloatArray:
        """What the work of each cell counts."""
        lattice = self.lattice
        busy = np.pad((self.work > 0).reshape(lattice.columns, lattice.rows).astype(np.float64), 1)
        around = sum(
            busy[1 + i : 1 + i + lattice.columns, 1 + j : 1 + j + lattice.rows]
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
            if i or j
        )
        secluded = 1.0 - np.asarray(around).ravel() / 8.0
        again = self._params.each_site * len(self._places) / lattice.sites
        values: FloatArray = (self.work + again) * (self.work > 0) * (1.0 + self._params.edge_bonus * secluded)
        return values

    def best_first(
        self, here: FloatArray, usable: BoolArray, values: FloatArray, reach_m: float, present: int | None
    ) -> int:
        """First site of the sequence of visits that does most work soonest."""
        params = self._params
        return best_first_visit(
            np.flatnonzero(usable), self.viewpoints, self.visits, values, here, reach_m, params.horizon_steps,
            params.visits_ahead, 2 * params.choices, -1 if present is None else present,
        )  # fmt: skip

    def gains(self, ends: FloatArray, situation: MappingSituation) -> FloatArray:
        """What one look from each end would add."""
        east_m, north_m, _ = situation.position_enu_m
        reach_m = min(situation.sensor.range_m, situation.sensor.footprint_m) + situation.reach_m
        self._near = open_near(self._places, self._open, east_m, north_m, reach_m)
        gains = np.empty(len(ends))
        immediate_gains(
            np.ascontiguousarray(ends), self._near, self._places, self._supposed, self._information,
            self._expectations(situation), self._sensor, gains,
        )  # fmt: skip
        return gains

    def _expectations(self, situation: MappingSituation) -> FloatArray:
        """(N,), what each landmark `near` counts: as far as trusted, and less where a teammate is nearer to it."""
        places = self._places[self._near]
        own = ((places - situation.position_enu_m[:2]) ** 2).sum(axis=1)
        worth = self._trust.copy()
        for mate in situation.teammates:
            theirs = ((places - mate.position_enu_m[:2]) ** 2).sum(axis=1)
            worth[self._near[theirs < own]] *= self._params.theirs
        return worth

    def ways_to(self, goal: Point, situation: MappingSituation) -> None:
        """Lay out how far it is to a goal from everywhere, over the ground as far as it is known."""
        lattice, known = self.terrain, situation.landmarks
        tops, means = np.empty(lattice.sites), np.empty(lattice.sites)
        cell_surfaces(lattice.first, lattice.order, known.heights_m, tops, means)
        fill_unknown(tops, lattice.columns, lattice.rows)
        band = situation.band
        self._flight = np.clip(tops + band.clearance_m, band.lowest_m, band.highest_m)
        self._distances = distances_to(
            lattice.cell_of(goal[0], goal[1]), self._flight, lattice.columns, lattice.rows, lattice.cell_m
        )

    def cost_to_go(self, ends: FloatArray, goal: Point) -> FloatArray:
        """Length of the way from each end to the goal of `ways_to`."""
        lattice = self.terrain
        target = np.array(goal)
        straight = np.linalg.norm(ends - target, axis=1)
        over = interpolated(
            self._distances, ends, lattice.west_m, lattice.south_m, lattice.cell_m, lattice.columns, lattice.rows
        )
        heights = interpolated(
            self._flight, ends, lattice.west_m, lattice.south_m, lattice.cell_m, lattice.columns, lattice.rows
        )
        over += _DESCENT * np.maximum(ends[:, 2] - heights, 0.0)
        near = np.clip(straight / (2.0 * lattice.cell_m), 0.0, 1.0)
        costs: FloatArray = near * over + (1.0 - near) * straight
        return costs


def _grown(cells: IndexArray, lattice: SiteLattice) -> IndexArray:
    """Cells and their neighbours."""
    columns, rows = np.divmod(cells, lattice.rows)
    grown = [
        np.clip(columns + i, 0, lattice.columns - 1) * lattice.rows + np.clip(rows + j, 0, lattice.rows - 1)
        for i in (-1, 0, 1)
        for j in (-1, 0, 1)
    ]
    return np.unique(np.concatenate(grown))


def _parts(lattice: SiteLattice, groups: int, elsewhere: float) -> FloatArray:
    """(groups, cells), how much each cell counts for each group: the area is halved until every group has its part."""
    part_of = np.zeros(lattice.sites, dtype=np.int64)
    columns, rows = np.divmod(np.arange(lattice.sites), lattice.rows)

    def halve(cells: IndexArray, first: int, count: int) -> None:
        if count == 1:
            part_of[cells] = first
            return
        wide, long = np.ptp(columns[cells]), np.ptp(rows[cells])
        along = (
            columns[cells] * lattice.rows + rows[cells]
            if wide >= long
            else rows[cells] * lattice.columns + columns[cells]
        )
        order = cells[np.argsort(along, kind="stable")]
        cut = round(len(order) * (count // 2) / count)
        halve(order[:cut], first, count // 2)
        halve(order[cut:], first + count // 2, count - count // 2)

    halve(np.arange(lattice.sites), 0, groups)
    return np.where(part_of[None, :] == np.arange(groups)[:, None], 1.0, elsewhere)
