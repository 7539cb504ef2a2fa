"""How uncertain an underwater vehicle's position has become, what mends it, and when a fix is worth the way up."""

from __future__ import annotations

import math
from collections import deque

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.reckoning import Reckoning, ReckoningParams
from vehicle_agent.mission.sounding import DRIFT_M_S, TYPICAL_SLOPE
from vehicle_agent.ports import VehicleState

FIX_DEPTH_M = 0.45
"""An antenna deeper than this hears no satellites."""
FIXED_SD_M = 1.0
FIX_TAKES_S = 2.0
"""At the surface until the fix counts."""
PLACES_KEPT_MS = 90_000
"""A teammate's packet is no later than this."""
NEAR_IN_TIME_MS = 1_000


class Drift:
    """Follows the position's error since the last fix (t_uw of Kapoutsis 2015, eq. 4), ranges to teammates included.

    Parameters
    ----------
    surface_up_m
        ENU z of the water's surface.
    dive_s
        Time from the surface to the working depth and back.
    sound_sd_m
        Standard deviation of a sounding with a perfect position.
    """

    def __init__(self, surface_up_m: float, dive_s: float, sound_sd_m: float) -> None:
        self._surface_up_m = surface_up_m
        self._cycle_s = dive_s + FIX_TAKES_S
        self._scale_s = sound_sd_m / (DRIFT_M_S * TYPICAL_SLOPE)
        self._reckoning = Reckoning(ReckoningParams(FIXED_SD_M, DRIFT_M_S))
        self._watched_s: float | None = None
        self._up_since_s: float | None = None
        self._gone_s = self._gathered_s = 0.0
        self._places: deque[tuple[int, Point]] = deque()

    @property
    def position_sd_m(self) -> float:
        """Standard deviation of the own position over ground, each axis."""
        return self._reckoning.sd_m

    @property
    def unfixed_s(self) -> float:
        """Seconds since a fix after which reckoning alone would be as uncertain as the position is now."""
        return math.sqrt(max(0.0, self._reckoning.sd_m**2 - FIXED_SD_M**2)) / DRIFT_M_S

    @property
    def has_fix(self) -> bool:
        """At the surface for long enough."""
        return self._gone_s == 0.0

    @property
    def ranges_used(self) -> int:
        """Ranges to teammates that have mended the position so far."""
        return self._reckoning.ranges_used

    @property
    def correction_m(self) -> tuple[float, float]:
        """What to add to the position that the autopilot reckons, east and north."""
        return self._reckoning.correction_m

    def watch(self, now_s: float, state: VehicleState) -> None:
        """Take the newest state, as the autopilot tells it; call at every step."""
        gone_s = 0.0 if self._watched_s is None else max(0.0, now_s - self._watched_s)
        if state.position_enu_m[2] < self._surface_up_m - FIX_DEPTH_M:
            self._up_since_s = None
        elif self._up_since_s is None:
            self._up_since_s = now_s
        if self._watched_s is None or (self._up_since_s is not None and now_s - self._up_since_s >= FIX_TAKES_S):
            self._reckoning.fix()
            self._gone_s = self._gathered_s = 0.0
            self._places.clear()
        elif gone_s > 0.0:
            before = self._worth()
            self._reckoning.advance(gone_s)
            self._gone_s += gone_s
            self._gathered_s += 0.5 * gone_s * (before + self._worth())
        self._watched_s = now_s
        self._places.append((state.stamp_ms, state.position_enu_m))
        while self._places[0][0] < state.stamp_ms - PLACES_KEPT_MS:
            self._places.popleft()

    def place_at(self, stamp_ms: int) -> Point:
        """Where the vehicle was at a time of its own clock, by what is known now; ENU metres.

        Between two states it went straight; before what is remembered and after the last state it stood.
        """
        after = next((number for number, (ms, _) in enumerate(self._places) if ms >= stamp_ms), len(self._places) - 1)
        after_ms, place = self._places[after]
        before_ms, before = self._places[max(0, after - 1)]
        if before_ms < stamp_ms < after_ms:
            share = (stamp_ms - before_ms) / (after_ms - before_ms)
            east, north, up = (a + share * (b - a) for a, b in zip(before, place, strict=True))
            place = (east, north, up)
        elif stamp_ms <= before_ms:
            place = before
        return (place[0] + self.correction_m[0], place[1] + self.correction_m[1], place[2])

    def hear_range(self, range_m: float, stamp_ms: int, teammate_enu_m: Point, teammate_sd_m: float) -> bool:
        """Fuse a range to a teammate, taken at a time at which it told where it was; whether that told anything."""
        if not self._places:
            return False
        then_ms, reckoned = min(self._places, key=lambda place: abs(place[0] - stamp_ms))
        if abs(then_ms - stamp_ms) > NEAR_IN_TIME_MS:
            return False
        return self._reckoning.hear_range(range_m, reckoned, teammate_enu_m, teammate_sd_m)

    def is_worth_a_fix(self) -> bool:
        """Whether soundings now tell less per second than they would on average with a fix at every such moment.

        A cycle costs the way up and down. The average is greatest where the falling rate meets it (the marginal value
        theorem). A range to a teammate lifts the rate, and so puts off the way up for as long as it is worth.
        """
        return self._worth() < self._gathered_s / (self._gone_s + self._cycle_s)

    def _worth(self) -> float:
        """A sounding's information over that with a fresh fix."""
        return 1.0 / (1.0 + (self.unfixed_s / self._scale_s) ** 2)
