"""Our planner of map missions: every vehicle alone chooses its next work site some visits ahead, and how to fly there.

Landmarks are gathered in cells. Of each cell the planner knows how much is left to do, from where, and how long that
takes by the sensor's equation. It looks several visits ahead for the most work in the least time, leaves to teammates
what they go for, and takes what lies beside its way when that is worth the time. Vehicles keep company in small groups:
a group's first goes where it likes within the group's own part of the area, the others work where they still hear it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.interface import Decision, Finished, Teammate, Wait, Waypoint
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

_MISSED_STEPS = 15
"""So long a teammate that is not heard is looked for where it was heard last; then it counts as lost."""
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
    visits_ahead
        Sites looked ahead.
    choices
        Sites considered at each of them.
    elsewhere
        How much a cell in another group's part counts.
    """

    cell_share: float = 0.75
    horizon_steps: float = 15.0
    edge_bonus: float = 2.0
    visits_ahead: int = 4
    choices: int = 5
    elsewhere: float = 0.1


class ViewpointPlanner:
    """Decides for one vehicle of a team; without dice, so that the same situations give the same decisions."""

    def __init__(self, vehicles: int, params: ViewpointParams | None = None) -> None:
        self._vehicles = vehicles
        self._params = params or ViewpointParams()
        self._sites: _Sites | None = None
        self._goal: int | None = None
        self._tired: set[int] = set()
        self._worth = 1.0
        self._stay = 0
        self._last_heard: dict[int, Teammate] = {}
        self._silent: dict[int, int] = {}

    def ask(self, situation: MappingSituation) -> Decision:
        """Where to go next; `Finished` when nothing that is known to this vehicle is left to do."""
        if self._sites is None:
            self._sites = _Sites(situation, self._params, self._vehicles)
        sites = self._sites
        sites.update(situation)
        if not sites.work.any():
            return Finished("every landmark is accurate or given up")
        goal, why = self._choose(situation, sites)
        end = self._step(situation, sites, goal)
        if end is None:
            return Wait("no way is open from here")
        return Waypoint(end, why, goal, math.dist(situation.position_enu_m, goal))

    def _choose(self, situation: MappingSituation, sites: _Sites) -> tuple[Point, str]:
        """The viewpoint to go for."""
        here = np.array(situation.position_enu_m)
        leader = self._leader(situation)
        usable = sites.work > 0.0
        values = sites.values()
        if self._tired:
            rested = usable.copy()
            rested[list(self._tired)] = False
            if rested.any():
                usable = rested
            else:
                self._tired.clear()
        if leader is None:
            values = values * sites.preference[self._group(situation.index)]
        for mate in situation.teammates:
            if mate.goal_enu_m is not None and (leader is not None or mate.index < situation.index):
                usable[sites.lattice.cell_of(mate.goal_enu_m[0], mate.goal_enu_m[1])] = False
        if leader is not None:
            anchor = np.array(leader.goal_enu_m if leader.goal_enu_m is not None else leader.position_enu_m)
            near = np.linalg.norm(sites.viewpoints - anchor, axis=1) <= 0.8 * situation.radio_range_m
            if not np.any(usable & near):
                return _point(anchor), f"keeps near vehicle {leader.index}"
            usable &= near
        if not usable.any():
            usable = sites.work > 0.0
        site = sites.best_first(here, usable, values, situation.reach_m, self._goal)
        self._note(site, sites, here, situation)
        return _point(sites.viewpoints[site]), f"{int(sites.work[site])} landmarks to estimate there"

    def _note(self, site: int, sites: _Sites, here: FloatArray, situation: MappingSituation) -> None:
        """Lose patience with a site that stays as it is though the vehicle has been there for long."""
        at_site = math.dist(sites.viewpoints[site, :2], here[:2]) <= 1.5 * situation.reach_m
        self._stay = self._stay + 1 if at_site and site == self._goal else 0
        if self._stay > 4 + 2 * sites.visits[site]:
            self._tired.add(site)
            self._stay = 0
        self._goal = site

    def _leader(self, situation: MappingSituation) -> Teammate | None:
        """Whom to keep near; None for who leads, and where the radio reaches everywhere or nobody is heard."""
        if math.isinf(situation.radio_range_m):
            return None
        self._silent = {index: silent + 1 for index, silent in self._silent.items()}
        for mate in situation.teammates:
            self._last_heard[mate.index], self._silent[mate.index] = mate, 0
        group = self._group(situation.index)
        mates = [
            mate
            for index, mate in self._last_heard.items()
            if self._group(index) == group and self._silent[index] <= _MISSED_STEPS
        ]
        if not mates and not situation.teammates:
            return None
        first = min(mates or situation.teammates, key=lambda mate: mate.index)
        return first if first.index < situation.index or not mates else None

    def _group(self, index: int) -> int:
        """Groups of two, the last of three where the number is odd."""
        return min(index // 2, max(self._vehicles // 2 - 1, 0))

    def _step(self, situation: MappingSituation, sites: _Sites, goal: Point) -> Point | None:
        """The admissible leg that gains most: what is measured at its end, and the time it brings the goal nearer."""
        here = np.array(situation.position_enu_m)
        ends = here + situation.reach_m * sites.ways
        ends[:, 2] = np.clip(ends[:, 2], situation.band.lowest_m, situation.band.highest_m)
        ends = ends[np.linalg.norm(ends - here, axis=1) <= situation.reach_m * (1.0 + 1e-9)]
        if len(ends) == 0:
            return None
        ends = ends[situation.admissible(ends)]
        if len(ends) == 0:
            return None
        gains = sites.gains(ends, situation)
        sites.ways_to(goal, situation)
        nearer = (sites.cost_to_go(here[None], goal)[0] - sites.cost_to_go(ends, goal)) / situation.reach_m
        scores = gains + self._worth * nearer
        best = int(np.argmax(scores))
        if nearer[best] < 0.05 and gains[best] < 0.2 * self._worth:
            best = int(np.argmax(ends[:, 2]))  # what is in the way is not where it was supposed: look from above
        self._worth = max(0.95 * self._worth + 0.05 * float(gains[best]), 0.3)
        sites.expect(ends[best])
        return _point(ends[best])


class _Sites:
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
        self.ways = _ways()
        keeps_height = situation.band.lowest_m == situation.band.highest_m
        self._heights = np.arange(1 if keeps_height else 6, dtype=np.int64)

    def update(self, situation: MappingSituation) -> None:
        """Look again at the cells whose landmarks have changed."""
        known = situation.landmarks
        information = known.information
        changed = information != self._information
        touched = self.lattice.home[changed]
        self._open = known.open
        self._learn(changed)
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
        values: FloatArray = self.work * (1.0 + self._params.edge_bonus * (1.0 - np.asarray(around).ravel() / 8.0))
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
            self._trust, self._sensor, gains,
        )  # fmt: skip
        return gains

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


def _ways() -> FloatArray:
    """Directions of a leg, evenly over the sphere, whole and half, and to stay: (97, 3)."""
    count = 64
    up = 1.0 - 2.0 * (np.arange(count) + 0.5) / count
    turn = math.pi * (1.0 + math.sqrt(5.0)) * np.arange(count)
    flat = np.sqrt(1.0 - up**2)
    sphere = np.column_stack((flat * np.cos(turn), flat * np.sin(turn), up))
    return np.vstack((np.zeros((1, 3)), sphere, 0.5 * sphere[::2]))


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


def _point(place: FloatArray) -> Point:
    return (float(place[0]), float(place[1]), float(place[2]))
