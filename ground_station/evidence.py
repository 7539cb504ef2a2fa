"""What a vehicle's statuses say over time: since when it has not moved, how fast it drains, whether its clock runs."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from vehicle_agent.wire.messages import PositionCm, Stage, Status

MOVED_M = 3.0
GETTING_ON = (Stage.WORKING, Stage.RETURNING)
RIVALS_KEPT = 4


@dataclass(frozen=True, slots=True)
class Evidence:
    """Bounded memory of one vehicle's statuses; stamps are Unix milliseconds, times are the station's seconds.

    Attributes
    ----------
    rest_cm, rest_since_ms
        Where it was when it last moved on, last saw new ground, or was last told to rest, and when.
    first_seen_cells
        As of then.
    leg_start_cm, leg_end_cm
        The leg it has reserved, and where it was when it reserved it.
    astray_since_ms
        Since when it has been far from its leg; 0 when it is not.
    full_ms, full_permille
        Stamp and charge of its first status under way; 0 and -1 before.
    stamp_ms, stamp_grew_s
        Its newest stamp, and the station time at which that stamp came.
    repeats
        Statuses since then with no newer stamp.
    rivals_s
        Station times at which another life of the same agent was heard after this one.
    """

    rest_cm: PositionCm = (0, 0, 0)
    rest_since_ms: int = 0
    first_seen_cells: int = 0
    leg_start_cm: PositionCm = (0, 0, 0)
    leg_end_cm: PositionCm = (0, 0, 0)
    astray_since_ms: int = 0
    full_ms: int = 0
    full_permille: int = -1
    stamp_ms: int = 0
    stamp_grew_s: float = 0.0
    repeats: int = 0
    rivals_s: tuple[float, ...] = ()

    def after(self, status: Status, arrival_s: float, astray_m: float) -> Evidence:
        """The evidence with one more status.

        Parameters
        ----------
        astray_m
            Distance from its leg beyond which a vehicle counts as far from its plan.
        """
        fresh = self
        moved_m = math.dist(self.rest_cm[:2], status.position_cm[:2]) / 100
        waits = status.stage not in GETTING_ON  # rests because it was told to
        news = moved_m > MOVED_M or status.first_seen_cells != self.first_seen_cells
        if not self.rest_since_ms or news or waits:
            fresh = replace(
                fresh,
                rest_cm=status.position_cm,
                rest_since_ms=status.stamp_ms,
                first_seen_cells=status.first_seen_cells,
            )
        if not self.rest_since_ms or status.leg_end_cm != self.leg_end_cm:
            fresh = replace(fresh, leg_start_cm=status.position_cm, leg_end_cm=status.leg_end_cm, astray_since_ms=0)
        off_m = distance_to_leg_m(status.position_cm, fresh.leg_start_cm, fresh.leg_end_cm)
        since_ms = (fresh.astray_since_ms or status.stamp_ms) if off_m > astray_m else 0
        grew = status.stamp_ms > self.stamp_ms
        under_way = status.armed and status.battery_permille >= 0
        return replace(
            fresh,
            astray_since_ms=since_ms,
            full_ms=(self.full_ms or status.stamp_ms) if under_way else 0,
            full_permille=(self.full_permille if self.full_ms else status.battery_permille) if under_way else -1,
            stamp_ms=max(self.stamp_ms, status.stamp_ms),
            stamp_grew_s=arrival_s if grew else self.stamp_grew_s,
            repeats=0 if grew else self.repeats + 1,
        )

    def with_rival(self, arrival_s: float) -> Evidence:
        """The evidence with one more word of another life of the same agent."""
        return replace(self, rivals_s=(*self.rivals_s, arrival_s)[-RIVALS_KEPT:])

    def drain_per_s(self, status: Status) -> float | None:
        """Permille of charge per second of vehicle time under way; None before there is enough to tell."""
        flown_s = (status.stamp_ms - self.full_ms) / 1_000
        if not self.full_ms or flown_s < 20.0 or status.battery_permille < 0:
            return None
        return max(0.0, (self.full_permille - status.battery_permille) / flown_s)


def distance_to_leg_m(place_cm: PositionCm, start_cm: PositionCm, end_cm: PositionCm) -> float:
    """Horizontal distance of a place to a straight leg, metres."""
    east, north = end_cm[0] - start_cm[0], end_cm[1] - start_cm[1]
    length_squared = east * east + north * north
    beside = (place_cm[0] - start_cm[0]) * east + (place_cm[1] - start_cm[1]) * north
    share = min(1.0, max(0.0, beside / length_squared)) if length_squared else 0.0
    return math.hypot(place_cm[0] - start_cm[0] - share * east, place_cm[1] - start_cm[1] - share * north) / 100
