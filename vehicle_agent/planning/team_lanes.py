"""The team's plan of lanes as one vehicle holds it: taken over from whoever made it better last, and made better."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.lane_sight import look_around, sight_of
from vehicle_agent.domain.lane_trials import Ways
from vehicle_agent.domain.shared_lanes import LaneCosts, mend_lanes
from vehicle_agent.planning.interface import AnnouncedLanes, Situation
from vehicle_agent.planning.patches import PatchDivision, UnseenPatches
from vehicle_agent.planning.steep_ground import ground_steepness
from vehicle_agent.planning.travel import EastNorth, along


@dataclass(frozen=True, slots=True)
class LanesParams:
    """How ways of lanes are planned.

    Attributes
    ----------
    block
        Width of the blocks of ground that are counted, in sensing ranges.
    sight
        How far is seen, as a share of the sensing range.
    most_bends
        Of one way.
    first_trials, trials
        Changes each vehicle tries at its first decision, and whenever it mends the plan later.
    large_team
        Vehicles of a larger team than this try fewer, together as many as those of such a team.
    first_hot, first_cool, hot, cool
        Heat of the annealing over all first decisions and later, in sensing ranges of way.
    unseen, dearer, allowed
        Way that ground as large as a squared sensing range is worth, in sensing ranges; beyond the allowed share of the
        area that may stay unseen it is worth so many times more.
    begins_ahead
        Ground nearer than this many ranges is not seen from where a vehicle is: its lane begins beyond.
    most_looked
        Share of the surest look that a fruitless look counts for at most: right above, all is tried again.
    arrived
        A bend that lies within so many sensing ranges of its vehicle is flown.
    """

    block: float = 0.25
    sight: float = 0.93
    most_bends: int = 48
    first_trials: int = 50_000
    trials: int = 10_000
    large_team: int = 8
    first_hot: float = 0.125
    first_cool: float = 0.003
    hot: float = 0.0125
    cool: float = 0.0025
    unseen: float = 1.6
    dearer: float = 4.0
    allowed: float = 0.004
    begins_ahead: float = 0.5
    most_looked: float = 0.4
    arrived: float = 0.15


UNITS_PER_CELL = 2
"""Bends are told in such parts of the map's cells: blocks may differ between vehicles that see differently far."""
MOST_BLOCKS = 90_000
"""Of wider ground the blocks are wider."""
LEAST_STRETCH = 0.6
"""However level ground is beside all other: so much nearer at most it seems to a sensor, squared."""
FLOWN_TOLD = 4
"""Bends that a vehicle reached last, told so that nobody plans them again."""
LOOKS_PER_MEND = 3
"""Places on the way since the last plan from where a vehicle is taken to have looked around."""
LAST_NUMBER = 2**32 - 1


class TeamLanes:
    """One vehicle's copy of the plan, and what it knows of the ground that the plan is for.

    Parameters
    ----------
    situation
        The first one: its map's grid is divided into blocks.
    home_en_m
        Where vehicles return to; None when they need not.
    """

    def __init__(self, situation: Situation, home_en_m: EastNorth | None, params: LanesParams) -> None:
        self._params, self._home_en_m, self._range_m = params, home_en_m, situation.range_m
        grid = situation.team_map.grid
        self._division = PatchDivision(grid, params.block * situation.range_m, MOST_BLOCKS)
        self._unseen = UnseenPatches(self._division)
        self._block_m = np.array(self._division.size_cells) * grid.cell_m
        self._range_blocks = situation.range_m / float(self._block_m.mean())
        self._sight = sight_of(params.sight * self._range_blocks, self._division.shape)
        self._middle_cells = self._division.middle_cells()
        self._looked_from: dict[int, FloatArray] = {}
        self._part_m, self._corner_en_m = grid.cell_m / UNITS_PER_CELL, (grid.west_m, grid.south_m)
        self._index = situation.index
        self._latest: AnnouncedLanes | None = None
        self._way: tuple[int, ...] = ()
        self._flown: tuple[int, ...] = ()

    @property
    def plan(self) -> AnnouncedLanes | None:
        """The plan as this vehicle tells it; None when it has none."""
        latest, index = self._latest, self._index
        if latest is None:
            return None
        own = zip(latest.vehicles, latest.ways, strict=True)
        ways = tuple(self._way if vehicle == index else way for vehicle, way in own)
        return AnnouncedLanes(latest.number, latest.by, latest.vehicles, ways, self._flown)

    @property
    def has_plan(self) -> bool:
        return self._latest is not None

    @property
    def bends_left(self) -> int:
        """Bends in the own way."""
        return len(self._way) // 2

    def bends_en_m(self, most: int | None = None) -> list[EastNorth]:
        """The first bends of the own way, or all, ENU metres."""
        part_m, (west_m, south_m) = self._part_m, self._corner_en_m
        way = self._way if most is None else self._way[: 2 * most]
        return [
            (west_m + part_m * east, south_m + part_m * north) for east, north in zip(way[::2], way[1::2], strict=True)
        ]

    def unseen_ranges2(self, situation: Situation) -> float:
        """How much is unseen, in squared sensing ranges."""
        self._unseen.follow(situation.team_map, situation.area_cells)
        return self._unseen.in_all() * self._division.grid.cell_m**2 / self._range_m**2

    def drop(self) -> None:
        """Forget the plan."""
        self._take_over(None)

    def _take_over(self, plan: AnnouncedLanes | None) -> None:
        self._latest = plan
        self._way = _not_flown(plan.way_of(self._index), self._flown) if plan else ()

    def mend(self, situation: Situation) -> None:
        """Drop what was flown from the latest plan and try changes to the rest."""
        params, scale = self._params, self._range_blocks
        mates = [mate for mate in situation.teammates if mate.lanes is not None or mate.tour is None]
        places = {mate.index: mate.position_enu_m for mate in mates}
        places[situation.index] = situation.position_enu_m
        indices = tuple(sorted(places))
        steepness = ground_steepness(
            situation.constraints.surface_m, *self._middle_cells, self._block_m, situation.range_m
        )
        self._sight.stretch[:] = np.maximum(steepness**2, LEAST_STRETCH)
        self._note_looks(indices, self._to_blocks(np.array([places[index][:2] for index in indices])))
        plans = [mate.lanes for mate in mates if mate.lanes is not None] + ([self._latest] if self._latest else [])
        latest = max(plans, key=lambda plan: (plan.number, plan.by), default=None)
        flown = {mate.index: mate.lanes.flown for mate in mates if mate.lanes is not None}
        flown[situation.index] = self._flown
        # Teammates fly on as they decided before: what is planned for them anew begins a step ahead of them.
        step_m = situation.constraints.reach_m
        places |= {mate.index: along(mate.position_enu_m, mate.goal_enu_m, step_m) for mate in mates if mate.goal_enu_m}
        starts = self._to_blocks(np.array([places[index][:2] for index in indices]))
        ways = self._ways(indices, starts, latest, flown)
        area_blocks = np.count_nonzero(situation.area_cells) / math.prod(self._division.size_cells)
        number = min(1 + (latest.number if latest else 0), LAST_NUMBER)
        trials, hot, cool = self._annealing(number, len(indices))
        costs = LaneCosts(
            0.0 if self._home_en_m is None else 1.0, params.unseen / scale, params.dearer,
            params.allowed * area_blocks, params.begins_ahead * scale, steepness,
        )  # fmt: skip
        mend_lanes(
            ways, self._sight, self._unseen.by_place() / math.prod(self._division.size_cells), costs,
            trials, hot * scale, cool * scale, np.random.default_rng((number, situation.index)),
        )  # fmt: skip
        told = tuple(self._told(bends[1:count]) for bends, count in zip(ways.bends, ways.counts, strict=True))
        self._take_over(AnnouncedLanes(number, situation.index, indices, told, self._flown))

    def _annealing(self, number: int, vehicles: int) -> tuple[int, float, float]:
        """How many changes to try for a plan, and the heat at first and at last, in sensing ranges.

        The first plan of each vehicle is a part of one long annealing.
        """
        params = self._params
        share = min(1.0, params.large_team / vehicles)
        if number > vehicles:
            return round(share * params.trials), params.hot, params.cool
        falls = params.first_cool / params.first_hot
        hot, cool = (params.first_hot * falls ** (part / vehicles) for part in (number - 1, number))
        return round(share * params.first_trials), hot, cool

    def reach(self, here_enu_m: Point, within_m: float) -> bool:
        """Take bends as near as that off the own way, as flown; tell whether there were any."""
        reached, (west_m, south_m) = False, self._corner_en_m
        while self._way:
            east_m, north_m = west_m + self._part_m * self._way[0], south_m + self._part_m * self._way[1]
            if math.hypot(east_m - here_enu_m[0], north_m - here_enu_m[1]) >= within_m:
                break
            self._flown = (*self._flown[2 - 2 * FLOWN_TOLD :], *self._way[:2])
            self._way = self._way[2:]
            reached = True
        return reached

    def _ways(
        self, indices: tuple[int, ...], starts: FloatArray, latest: AnnouncedLanes | None,
        flown: dict[int, tuple[int, ...]],
    ) -> Ways:  # fmt: skip
        """The latest plan from where vehicles start, in blocks."""
        bends = np.zeros((len(indices), self._params.most_bends, 2))
        counts = np.ones(len(indices), dtype=np.int64)
        bends[:, 0] = starts
        arrived = self._params.arrived * self._range_blocks
        for row, index in enumerate(indices):
            told = _not_flown(latest.way_of(index), flown.get(index, ())) if latest else ()
            way = self._to_blocks(self._heard(told)[: self._params.most_bends - 1])
            if len(way) and math.dist(way[0], starts[row]) < arrived:
                way = way[1:]
            counts[row] = 1 + len(way)
            bends[row, 1 : counts[row]] = way
        homes = starts.copy()
        if self._home_en_m is not None:
            homes[:] = self._to_blocks(np.array([self._home_en_m]))
        return Ways(bends, counts, homes)

    def _note_looks(self, indices: tuple[int, ...], places: FloatArray) -> None:
        """Note that vehicles looked around on their ways to where they are, in blocks."""
        shares = np.linspace(0.0, 1.0, LOOKS_PER_MEND, endpoint=False)[:, None]
        since = [self._looked_from.get(index, place) for index, place in zip(indices, places, strict=True)]
        looks = np.concatenate([place + shares * (before - place) for place, before in zip(places, since, strict=True)])
        look_around(self._sight, looks, int(self._params.most_looked * self._sight.odds[0]))
        self._looked_from = dict(zip(indices, places, strict=True))

    def _heard(self, way: tuple[int, ...]) -> FloatArray:
        """Bends as told -> (N, 2) float64, ENU metres."""
        return np.array(way, dtype=np.float64).reshape(-1, 2) * self._part_m + self._corner_en_m

    def _told(self, bends: FloatArray) -> tuple[int, ...]:
        """Bends in blocks, (N, 2) float64 -> as told."""
        places_en_m = (bends + 0.5) * self._block_m + self._division.corner_en_m
        told = np.rint((places_en_m - self._corner_en_m) / self._part_m)
        return tuple(told.astype(np.int64).ravel().tolist())

    def _to_blocks(self, places_en_m: FloatArray) -> FloatArray:
        """Places in blocks, block centres at whole numbers: (N, 2) metres -> (N, 2)."""
        blocks: FloatArray = (places_en_m - self._division.corner_en_m) / self._block_m - 0.5
        return blocks


def _not_flown(way: tuple[int, ...], flown: tuple[int, ...]) -> tuple[int, ...]:
    """A way without the bends at its beginning that its vehicle has reached already."""
    reached = [flown[place : place + 2] for place in range(0, len(flown), 2)]
    while way[:2] in reached:
        way = way[2:]
    return way
