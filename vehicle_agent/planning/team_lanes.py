"""The team's plan of lanes as one vehicle holds it: taken over from whoever made it better last, and made better."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.lane_trials import Ways
from vehicle_agent.domain.shared_lanes import LaneCosts, annealing_of
from vehicle_agent.planning.interface import AnnouncedLanes, Situation, Teammate
from vehicle_agent.planning.lane_ground import LaneGround, LaneGroundParams
from vehicle_agent.planning.lane_mending import LaneMending
from vehicle_agent.planning.own_way import OwnWay, without_flown
from vehicle_agent.planning.travel import EastNorth, along


@dataclass(frozen=True, slots=True)
class LanesParams:
    """How ways of lanes are planned.

    Attributes
    ----------
    ground
        How the ground is looked at.
    most_bends
        Of one way.
    first_trials, trials
        Changes each vehicle tries for one of the first plans, and whenever it mends the plan later.
    large_team
        Vehicles of a larger team than this try fewer, together as many as those of such a team.
    few_try
        Those of a smaller team try more, also as many together, but no one more than so many times as many: first
        plans are more then, since while a vehicle plans its teammates hear nothing of it.
    first_hot, first_cool, hot, cool
        Heat of the annealing over all first plans and later, in sensing ranges of way.
    unseen, dearer, allowed
        Way that ground as large as a squared sensing range is worth, in sensing ranges; beyond the allowed share of the
        ground that may stay unseen it is worth so many times more.
    begins_ahead
        Ground nearer than this many ranges is not seen from where a vehicle is: its lane begins beyond.
    arrived
        A bend that lies within so many sensing ranges of its vehicle is flown.
    """

    ground: LaneGroundParams = field(default_factory=LaneGroundParams)
    most_bends: int = 48
    first_trials: int = 50_000
    trials: int = 10_000
    large_team: int = 8
    few_try: int = 2
    first_hot: float = 0.125
    first_cool: float = 0.003
    hot: float = 0.0125
    cool: float = 0.0025
    unseen: float = 1.6
    dearer: float = 4.0
    allowed: float = 0.004
    begins_ahead: float = 0.5
    arrived: float = 0.15


LAST_NUMBER = 2**32 - 1


class TeamLanes:
    """One vehicle's copy of the plan.

    Parameters
    ----------
    situation
        The first one: its map's grid is the ground that the plan is for.
    home_en_m
        Where vehicles return to; None when they need not.

    Attributes
    ----------
    own
        What is left of the vehicle's own way.
    """

    def __init__(self, situation: Situation, home_en_m: EastNorth | None, params: LanesParams) -> None:
        self._params, self._home_en_m = params, home_en_m
        self._ground = LaneGround(situation, params.ground)
        self._index = situation.index
        self._latest: AnnouncedLanes | None = None
        self._mending: LaneMending | None = None
        self.own = OwnWay.over(situation.team_map.grid)

    @property
    def ground(self) -> LaneGround:
        """What the plan is for."""
        return self._ground

    @property
    def has_plan(self) -> bool:
        return self._latest is not None

    @property
    def plan(self) -> AnnouncedLanes | None:
        """The plan as this vehicle tells it; None when it has none."""
        return self.plan_with(self.own)

    def plan_with(self, own: OwnWay) -> AnnouncedLanes | None:
        """The plan as this vehicle tells it when so much is left of its own way; None when it has none."""
        latest, index = self._latest, self._index
        if latest is None:
            return None
        told = zip(latest.vehicles, latest.ways, strict=True)
        ways = tuple(own.left if vehicle == index else way for vehicle, way in told)
        return AnnouncedLanes(latest.number, latest.by, latest.vehicles, ways, own.flown)

    def drop(self) -> None:
        """Forget the plan."""
        self._mending = None
        self._take_over(None)

    def _take_over(self, plan: AnnouncedLanes | None) -> None:
        self._latest = plan
        self.own = self.own.on(plan.way_of(self._index) if plan else ())

    def begin(self, situation: Situation, place_enu_m: Point) -> None:
        """Begin to mend the plan for a decision at a place, unless that is begun."""
        vehicles = tuple(sorted((situation.index, *(mate.index for mate in _planned_for(situation)))))
        begun, near_m = self._mending, situation.constraints.reach_m
        if begun is None or not begun.is_for(vehicles, place_enu_m, near_m):
            self._mending = self._begun(situation, place_enu_m)

    def go_on(self, most: int) -> bool:
        """Try so many changes more of those begun with at most; True when none are left."""
        return self._mending is None or self._mending.go_on(most)

    def mend(self, situation: Situation) -> None:
        """Make the plan better; what was begun is brought to its end."""
        self.begin(situation, situation.position_enu_m)
        if (mending := self._mending) is None:
            return
        ways = tuple(self._told(way) for way in mending.finished_ways())
        mended = AnnouncedLanes(mending.number, situation.index, mending.vehicles, ways, self.own.flown)
        self._mending = None
        heard = _latest(mate.lanes for mate in _planned_for(situation))
        # A plan of the last number counts no more than one's own, else nobody could plan any longer.
        is_newer = heard is not None and _order(mended) < _order(heard) < (LAST_NUMBER, 0)
        self._take_over(heard if is_newer else mended)

    def _begun(self, situation: Situation, place_enu_m: Point) -> LaneMending:
        """The latest plan without what was flown of it, and the changes that are to be tried."""
        params, scale = self._params, self._ground.range_blocks
        mates = _planned_for(situation)
        places = {mate.index: mate.position_enu_m for mate in mates}
        places[situation.index] = situation.position_enu_m
        indices = tuple(sorted(places))
        latest = _latest([self._latest, *(mate.lanes for mate in mates)])
        flown = {mate.index: mate.lanes.flown for mate in mates if mate.lanes is not None}
        flown[situation.index] = self.own.flown
        reached = np.concatenate([self._heard(bends) for bends in flown.values()])
        outlook = self._ground.look_out(situation, dict(zip(indices, self._in_blocks(places), strict=True)), reached)
        # Teammates fly on as they decided before: what is planned for them anew begins a step ahead of them.
        step_m = situation.constraints.reach_m
        places[situation.index] = place_enu_m
        places |= {mate.index: along(mate.position_enu_m, mate.goal_enu_m, step_m) for mate in mates if mate.goal_enu_m}
        ways = self._ways(indices, self._in_blocks(places), latest, flown)
        number = min(1 + (latest.number if latest else 0), LAST_NUMBER)
        trials, hot, cool = self._annealing(number, len(indices))
        window, comes_home = outlook.window, self._home_en_m is not None and outlook.window.is_all
        costs = LaneCosts(
            1.0 if comes_home else 0.0, params.unseen / scale, params.dearer,
            params.allowed * outlook.whole_blocks, params.begins_ahead * scale,
        )  # fmt: skip
        ways.bends[:] -= window.corner
        ways.homes[:] -= window.corner
        annealing = annealing_of(ways, trials, hot * scale, cool * scale)
        rng = np.random.default_rng((number, situation.index))
        return LaneMending(number, indices, place_enu_m, outlook, costs, ways, annealing, rng)

    def _annealing(self, number: int, vehicles: int) -> tuple[int, float, float]:
        """How many changes to try for a plan, and the heat at first and at last, in sensing ranges.

        The first plans are parts of one long annealing.
        """
        params = self._params
        share = params.large_team / vehicles
        firsts = max(vehicles, min(params.few_try * vehicles, params.large_team))
        if number > firsts:
            return round(min(params.few_try, share) * params.trials), params.hot, params.cool
        falls = params.first_cool / params.first_hot
        hot, cool = (params.first_hot * falls ** (part / firsts) for part in (number - 1, number))
        return round(min(1.0, share) * params.first_trials), hot, cool

    def _ways(
        self, indices: tuple[int, ...], starts: FloatArray, latest: AnnouncedLanes | None,
        flown: dict[int, tuple[int, ...]],
    ) -> Ways:  # fmt: skip
        """The latest plan from where vehicles start, in blocks."""
        bends = np.zeros((len(indices), self._params.most_bends, 2))
        counts = np.ones(len(indices), dtype=np.int64)
        bends[:, 0] = starts
        arrived = self._params.arrived * self._ground.range_blocks
        for row, index in enumerate(indices):
            told = without_flown(latest.way_of(index), flown.get(index, ())) if latest else ()
            way = self._heard(told[: 2 * (self._params.most_bends - 1)])
            if len(way) and math.dist(way[0], starts[row]) < arrived:
                way = way[1:]
            counts[row] = 1 + len(way)
            bends[row, 1 : counts[row]] = way
        homes = starts.copy()
        if self._home_en_m is not None:
            homes[:] = self._ground.to_blocks(np.array([self._home_en_m]))
        return Ways(bends, counts, homes)

    def _in_blocks(self, places_enu_m: dict[int, Point]) -> FloatArray:
        """Places by ascending index: (N, 2) float64, blocks."""
        return self._ground.to_blocks(np.array([places_enu_m[index][:2] for index in sorted(places_enu_m)]))

    def _heard(self, way: tuple[int, ...]) -> FloatArray:
        """Bends as told -> (N, 2) float64, blocks; a bend beside the ground, as of another mission's, at its edge."""
        bends_en_m = np.array(way, dtype=np.float64).reshape(-1, 2) * self.own.part_m + self.own.corner_en_m
        return self._ground.inside(self._ground.to_blocks(bends_en_m))

    def _told(self, bends: FloatArray) -> tuple[int, ...]:
        """Bends in blocks, (N, 2) float64 -> as told."""
        told = np.rint((self._ground.to_metres(bends) - self.own.corner_en_m) / self.own.part_m)
        return tuple(told.astype(np.int64).ravel().tolist())


def _planned_for(situation: Situation) -> list[Teammate]:
    """Teammates that a plan is for: those that tell one, and those that tell no tour of their own."""
    return [mate for mate in situation.teammates if mate.lanes is not None or mate.tour is None]


def _latest(plans: Iterable[AnnouncedLanes | None]) -> AnnouncedLanes | None:
    """Of plans the one that counts; None when there is none."""
    return max((plan for plan in plans if plan is not None), key=_order, default=None)


def _order(plan: AnnouncedLanes) -> tuple[int, int]:
    return plan.number, plan.by
