"""Tours: decentralised exploration in which the team shares the unseen ground out as tours of equal length.

The unseen ground is divided into patches about as wide as a sensor sees, and stops are chosen in as few of them as show
all of it. Each vehicle announces the order in which it means to visit its stops' patches; whoever decides puts the
announced tours together, mends them a little so that the longest becomes shorter (from the team's map and its
teammates' positions alone), flies its own and announces it. On the way to a stop it bends its path to where it sees
more unseen ground in passing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.sweeps import unseen_beside
from vehicle_agent.planning.frontier_travel import bearing_word
from vehicle_agent.planning.interface import (
    AnnouncedTour,
    Decision,
    Finished,
    Observation,
    Situation,
    Wait,
    Waypoint,
)
from vehicle_agent.planning.patches import PatchDivision, UnseenPatches
from vehicle_agent.planning.team_tours import Tourist, own_tour
from vehicle_agent.planning.travel import EastNorth, along, beyond, next_leg, next_step, way_length_m


@dataclass(frozen=True, slots=True)
class ToursParams:
    """How the ground is shared out and swept.

    Attributes
    ----------
    patch_width
        Width of a patch in sensing ranges.
    service
        Extra way that a wholly unseen patch costs, in patch widths.
    stop_radius
        From a stop, ground within this many sensing ranges is taken to be seen: what the stops of the patches around
        show needs no other.
    remnant_share, seen_beside
        A patch with less than this share unseen is no stop of its own when a stop lies within `seen_beside` sensing
        ranges of it: whoever goes there sees it in passing.
    first_trials, trials, most_taken
        Changes tried to the very first tours and at each decision, and patches moved at once.
    leg
        A decision holds for this many sensing ranges: for as many whole steps as fit, and one at least; what is left
        over counts for the next.
    sweep_radius, sweep_length, sweep_weight
        A way is worth what lies unseen within this many sensing ranges of its first `sweep_length` ranges, as length
        of a way through unseen ground; so much detour, times the weight, it may cost.
    look_closer_after
        Fruitless decisions after which a patch is approached at its nearest unseen cell, no more at the middle of them.
    patience
        Fruitless decisions, neither nearer nor seeing more, after which a patch is given up; when nothing else is left
        those given up are tried once more, since what stood in the way may have gone.
    """

    patch_width: float = 1.0
    service: float = 0.2
    stop_radius: float = 0.75
    remnant_share: float = 0.4
    seen_beside: float = 0.85
    first_trials: int = 300
    trials: int = 50
    most_taken: int = 8
    leg: float = 0.5625
    sweep_radius: float = 0.8
    sweep_length: float = 0.5
    sweep_weight: float = 1.5
    look_closer_after: int = 2
    patience: int = 6


TO_AND_FRO = 4
"""A patch may be approached again from afar for so many times the patience."""
BENDS_RAD = np.array([0.0, 0.3, -0.3, 0.6, -0.6, 0.9, -0.9, 1.2, -1.2])
"""Headings tried, away from the straight way to a patch."""


@dataclass(slots=True)
class _Effort:
    """What has been tried for one patch.

    Attributes
    ----------
    unseen, nearest_m
        The least so far.
    last_m
        Distance at the last decision.
    fruitless
        Decisions in a row that brought the vehicle no nearer and showed no more of it.
    without_best
        Decisions since the last that was better than all before: going to and fro comes to an end by it.
    """

    unseen: float = math.inf
    nearest_m: float = math.inf
    last_m: float = math.inf
    fruitless: int = 0
    without_best: int = 0

    def note(self, unseen: int, away_m: float, step_m: float) -> None:
        more_seen = unseen < self.unseen
        self.fruitless = 0 if more_seen or away_m < self.last_m - step_m else self.fruitless + 1
        self.without_best = 0 if more_seen or away_m < self.nearest_m - step_m else self.without_best + 1
        self.unseen, self.nearest_m = min(unseen, self.unseen), min(away_m, self.nearest_m)
        self.last_m = away_m


class TourExplorer:
    """One vehicle's part in the team's tours."""

    def __init__(self, home_en_m: EastNorth | None, range_m: float, params: ToursParams | None = None) -> None:
        self._params = params or ToursParams()
        self._home_en_m = None if home_en_m is None else np.array(home_en_m)
        self._range_m = range_m
        self._division: PatchDivision | None = None
        self._unseen: UnseenPatches | None = None
        self._tour: AnnouncedTour | None = None
        self._tour_en_m: list[EastNorth] = []
        self._patch: int | None = None
        self._farthest = (0, 0)
        self._waypoint: Waypoint | None = None
        self._part_of_a_step = 0.0
        self._leg_end: Point = (0.0, 0.0, 0.0)
        self._given_up: set[int] = set()
        self._tried_again = False
        self._efforts: dict[int, _Effort] = {}

    def tell(self, observation: Observation) -> None:
        """Nothing is learned from measurements beyond the map."""

    def ask(self, situation: Situation) -> Decision:
        if self._division is None or self._unseen is None:
            width_m = self._params.patch_width * self._range_m
            self._division = PatchDivision(situation.team_map.grid, width_m)
            self._unseen = UnseenPatches(self._division)
        before = self._waypoint
        if before is not None and self._has_unseen(situation, self._unseen):
            step = next_step(situation.position_enu_m, self._leg_end, situation.constraints)
            if step is not None:
                goal, cost_m, told_enu_m = before.goal_enu_m, before.goal_cost_m, before.route_enu_m
                return Waypoint(step, before.why, goal, cost_m, told_enu_m, before.tour)
        self._waypoint = None
        self._unseen.follow(situation.team_map, situation.area_cells)
        if not self._share_out(situation, self._division, self._unseen):
            return Finished("nothing unseen is left within reach")
        assert self._patch is not None
        stop, nearest, unseen = self._unseen_of(situation, self._division, self._patch)
        effort = self._efforts.setdefault(self._patch, _Effort())
        target = stop if effort.without_best < self._params.look_closer_after else nearest
        here = situation.position_enu_m
        away_m = way_length_m(here, target)
        effort.note(unseen, way_length_m(here, nearest), 0.25 * situation.team_map.grid.cell_m)
        if max(effort.fruitless, effort.without_best / TO_AND_FRO) >= self._params.patience:
            self._given_up.add(self._patch)
            self._patch = None
            return Wait("gave up a patch: no way to see the rest of it")
        what = f"unseen patch {away_m:.0f} m {bearing_word(here[:2], target)}"
        end = self._leg(situation, target, away_m)
        if end is None:
            return Wait(f"{what}: the way is taken")
        goal = (*self._tour_en_m[0], end[2])
        route = [(target[0], target[1], end[2]), *((e, n, end[2]) for e, n in self._tour_en_m[1:])]
        why = f"{what}, first of {len(self._tour_en_m)} in its tour"
        self._leg_end = end
        first = along(here, end, situation.constraints.reach_m)
        self._waypoint = Waypoint(first, why, goal, away_m, tuple(route[:12]), self._tour)
        return self._waypoint

    def _has_unseen(self, situation: Situation, unseen: UnseenPatches) -> bool:
        """Whether anything of the patch is unseen yet: all is counted once its farthest cell was seen."""
        first_stamp_ms = situation.team_map.first_stamp_ms[self._farthest]
        if situation.area_cells[self._farthest] and first_stamp_ms == UNOBSERVED_STAMP_MS:
            return True
        unseen.follow(situation.team_map, situation.area_cells)
        return self._patch is not None and unseen.unseen_in(self._patch) > 0

    def _leg(self, situation: Situation, target: EastNorth, away_m: float) -> Point | None:
        """End of the next leg towards a target, bent to where more unseen ground lies beside it."""
        constraints = situation.constraints
        here = situation.position_enu_m
        steps_m = self._params.leg * self._range_m + self._part_of_a_step * constraints.reach_m
        steps = max(1, int(steps_m / constraints.reach_m + 1e-9))
        self._part_of_a_step = min(max(steps_m / constraints.reach_m - steps, 0.0), 0.99)
        if away_m < constraints.reach_m and len(self._tour_en_m) > 1:
            target = beyond(target, self._tour_en_m[1], constraints.reach_m - away_m)
        bent = self._bent(situation, target)
        if bent is not None:
            end = next_leg(here, bent, constraints, steps)
            if end is not None and math.dist(end[:2], here[:2]) > 0.25 * constraints.reach_m:
                return end
        return next_leg(here, target, constraints, steps)

    def _bent(self, situation: Situation, target: EastNorth) -> EastNorth | None:
        """A place beside the way to a target that is worth the detour; None when straight on is best."""
        params, grid = self._params, situation.team_map.grid
        here = situation.position_enu_m
        away_m = way_length_m(here, target)
        if away_m < 0.25 * self._range_m:
            return None
        length_m = min(params.sweep_length * self._range_m, away_m)
        headings = math.atan2(target[1] - here[1], target[0] - here[0]) + BENDS_RAD
        ends = np.column_stack((here[0] + length_m * np.cos(headings), here[1] + length_m * np.sin(headings)))
        corner = np.array([grid.west_m, grid.south_m])
        radius_m = params.sweep_radius * self._range_m
        start_cells, ends_cells = (np.array(here[:2]) - corner) / grid.cell_m - 0.5, (ends - corner) / grid.cell_m - 0.5
        beside = unseen_beside(
            situation.team_map.first_stamp_ms, situation.area_cells, start_cells, ends_cells, radius_m / grid.cell_m
        )
        detours_m = np.hypot(*(ends - np.array(target)).T) + length_m - away_m
        worth_m = params.sweep_weight * beside * grid.cell_m**2 / (2.0 * radius_m) - detours_m
        inside = (ends_cells > 0.1) & (ends_cells < np.array(grid.shape) - 1.1)
        best = int(np.argmax(np.where(inside.all(axis=1), worth_m, -math.inf)))
        return None if best == 0 or worth_m[best] <= worth_m[0] else (float(ends[best, 0]), float(ends[best, 1]))

    def _share_out(self, situation: Situation, division: PatchDivision, unseen: UnseenPatches) -> bool:
        """Mend the team's tours and take the own one; False when nothing is left."""
        params = self._params
        if not unseen.any_left(self._given_up) and not self._tried_again:
            self._tried_again = True
            self._given_up.clear()
            self._efforts.clear()
        whole = division.size_cells[0] * division.size_cells[1]
        stops = unseen.stops(
            self._given_up,
            params.stop_radius * self._range_m,
            params.remnant_share * whole,
            params.seen_beside * self._range_m,
        )
        if len(stops) == 0:
            return False
        team = [Tourist(situation.index, situation.position_enu_m, self._tour)]
        team += [Tourist(mate.index, mate.position_enu_m, mate.tour) for mate in situation.teammates]
        team.sort(key=lambda member: member.index)
        service_m = params.service * params.patch_width * self._range_m * np.minimum(1.0, stops.unseen / whole)
        trials = params.trials if any(member.tour for member in team) else params.first_trials
        self._tour = own_tour(team, situation.index, stops, service_m, self._home_en_m, trials, params.most_taken)
        place_of = {int(number): place for place, number in enumerate(stops.numbers)}
        own = [place_of[number] for number in self._tour.patches]
        if not own:
            own = [_nearest(stops.places_en_m, situation.position_enu_m)]
        self._patch = int(stops.numbers[own[0]])
        self._tour_en_m = [(float(e), float(n)) for e, n in stops.places_en_m[own]]
        return True

    def _unseen_of(self, situation: Situation, division: PatchDivision, patch: int) -> tuple[EastNorth, EastNorth, int]:
        """Where to go in a patch, the nearest of its unseen cells, and how many there are.

        That is its stop; in a patch wider than a sensor sweeps, the middle of the unseen cells that lie in the same
        square of that width as the nearest.
        """
        columns, rows = division.cells_of(patch)
        across, along = np.nonzero(
            situation.area_cells[columns, rows] & ~situation.team_map.observed_in((columns, rows))
        )
        grid = situation.team_map.grid
        points = grid.centres_of((across + columns.start) * grid.rows + along + rows.start)
        first, last = _nearest(points, situation.position_enu_m), _farthest(points, situation.position_enu_m)
        self._farthest = (int(across[last]) + columns.start, int(along[last]) + rows.start)
        nearest, stop = points[first], np.array(self._tour_en_m[0])
        square_cells = math.ceil(self._params.patch_width * self._range_m / grid.cell_m)
        if max(division.size_cells) > square_cells:
            beside = (across // square_cells == across[first] // square_cells) & (
                along // square_cells == along[first] // square_cells
            )
            stop = points[beside].mean(axis=0)
        return (float(stop[0]), float(stop[1])), (float(nearest[0]), float(nearest[1])), len(points)


def _nearest(points_en_m: FloatArray, position_enu_m: Point) -> int:
    return int(np.argmin(np.hypot(*(points_en_m - np.array(position_enu_m[:2])).T)))


def _farthest(points_en_m: FloatArray, position_enu_m: Point) -> int:
    return int(np.argmax(np.hypot(*(points_en_m - np.array(position_enu_m[:2])).T)))
