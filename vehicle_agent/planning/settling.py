"""When a team that looks for places to stay has settled: counted by each vehicle from what all of them tell."""

from __future__ import annotations

import math
from dataclasses import dataclass

from vehicle_agent.domain.frames import Point
from vehicle_agent.planning.interface import Teammate

RESTING = 6
"""Decisions without any movement after which a teammate is taken to stay where it is, whatever it said."""
STUCK = 25
"""Decisions without coming any nearer to its station after which a vehicle lets it go."""
LEAVING = 0.7
"""Share of the quiet time before the end after which a teammate that leaves has not failed but is done."""
LEAVING_EARLY = 20
"""So many decisions before the end, too: vehicles do not begin to count at the same moment."""


@dataclass(frozen=True, slots=True)
class SettlingParams:
    """How a vehicle looks for a place to stay, and how long a team takes to settle; times in decisions of a vehicle.

    Attributes
    ----------
    local_scales
        Standard deviations of proposals around the own station, in sensing ranges.
    per_scale
        Proposals of each.
    far
        Proposals around surface that no claimed station sees.
    heat
        Standard deviation of the first noise, as a share of what a whole view shows.
    heated_decisions
        Decisions until the noise is gone.
    patience
        Cold decisions without gain after which a vehicle has settled.
    hold
        Decisions without any change in the team, beyond `patience`, after which the task is done.
    """

    local_scales: tuple[float, ...] = (0.03, 0.1, 0.3)
    per_scale: int = 8
    far: int = 12
    heat: float = 0.02
    heated_decisions: int = 100
    patience: int = 20
    hold: int = 1

    def __post_init__(self) -> None:
        if self.per_scale < 0 or self.far < 0 or self.heated_decisions < 0:
            raise ValueError("per_scale, far and heated_decisions must not be negative")
        if not self.heat >= 0.0 or self.patience < 1:
            raise ValueError("heat must not be negative, patience not 0")


class Settling:
    """What one vehicle counts.

    Attributes
    ----------
    decisions
        Of this vehicle; a change of the team sets them back, so that there is room to leave the present places again.
    """

    def __init__(self, params: SettlingParams) -> None:
        self._params = params
        self.decisions = 0
        self._stale = 0
        self._quiet = 0
        self._stuck = 0
        self._rest: dict[int, tuple[Point, Point | None]] = {}
        self._team: tuple[int, ...] = ()

    @property
    def cooled(self) -> float:
        """0 at the beginning; 1 and more once the noise is gone."""
        return self.decisions / max(1, self._params.heated_decisions)

    @property
    def is_cold(self) -> bool:
        return self.decisions >= self._params.heated_decisions

    @property
    def looks_on(self) -> bool:
        """A better station may still be found."""
        return self._stale < self._params.patience

    @property
    def is_done(self) -> bool:
        """Nobody has moved or changed its mind for as long as was to be."""
        return self.is_cold and self._quiet >= self._params.patience + self._params.hold

    @property
    def is_stuck(self) -> bool:
        """The vehicle does not come nearer to its station."""
        return self._stuck >= STUCK

    def meet(self, teammates: tuple[Teammate, ...]) -> bool:
        """Take in who is in the team; True when somebody died or joined, so that all is to be thought over."""
        team = tuple(mate.index for mate in teammates)
        changed = bool(team != self._team and self._team and not self._nearly_ends)
        if changed:
            self.decisions = min(self.decisions, self._params.heated_decisions // 2)
            self._stale = 0
        self._team = team
        return changed

    def found(self, better: bool) -> None:
        """Note whether a decision found a better station."""
        self._stale = 0 if better else self._stale + 1

    def look_again(self) -> None:
        """Whatever was found out before, there may be something better now."""
        self._stale = 0

    def arrive(self) -> None:
        """The vehicle is on its station."""
        self._stuck = 0

    def places(self, teammates: tuple[Teammate, ...], near_m: float) -> list[Point]:
        """Where each teammate will stay: its station, or where it rests if word of a new one was lost."""
        rests = self._quiet >= RESTING
        return [
            mate.position_enu_m
            if mate.goal_enu_m is None or (rests and math.dist(mate.position_enu_m, mate.goal_enu_m) > 2.0 * near_m)
            else mate.goal_enu_m
            for mate in teammates
        ]

    def count(
        self, index: int, position_enu_m: Point, station_enu_m: Point, teammates: tuple[Teammate, ...], near_m: float,
        periods: int = 1,
    ) -> None:  # fmt: skip
        """Count decisions since anybody last moved or changed its mind, which all hear of at about the same time.

        A vehicle that is slow to decide counts the `periods` in which it should have: else the others would end before
        it, and it would take those who go home for lost.
        """
        places = {mate.index: (mate.position_enu_m, mate.goal_enu_m) for mate in teammates}
        places[index] = (position_enu_m, station_enu_m)
        was = self._rest.get(index)
        moved = was is None or math.dist(was[0], position_enu_m) > near_m
        self._stuck = 0 if moved else self._stuck + 1
        same = all(
            other in self._rest
            and self._rest[other][1] == goal
            and math.dist(self._rest[other][0], position) <= 2.0 * near_m
            for other, (position, goal) in places.items()
        )
        if same or self._ends:
            self._quiet += periods
        else:
            self._quiet, self._rest = 0, places

    @property
    def _ends(self) -> bool:
        """All have been quiet for nearly long enough: whoever moves now goes home, and nobody need replace it."""
        return self._quiet >= LEAVING * (self._params.patience + self._params.hold)

    @property
    def _nearly_ends(self) -> bool:
        """Somebody who counts from an earlier moment may be done by now."""
        left = self._params.patience + self._params.hold - self._quiet
        return self._ends or (self._quiet >= RESTING and left <= LEAVING_EARLY)
