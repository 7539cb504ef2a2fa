"""A simulated modem's ranges in flown runs: the simulator tells where bodies are, the agent hears how far apart."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.reckoning import noisy_range_m
from vehicle_agent.ports import TeammateRange
from vehicle_agent.wire.messages import AnyMessage, BodyReport, Landmarks

KEPT_REPORTS = 120
AHEAD_MS = 1_500
"""So much later than the last report a position is still carried on from the last two."""


class Link(Protocol):
    """The part of `FleetLink` that hears the simulator."""

    def subscribe(self, topic_name: str, participant: str = "*") -> None: ...

    def poll(self) -> Sequence[AnyMessage]: ...


class SimulatedRanging:
    """Gives a range with every packet of a teammate that tells where it was.

    Parameters
    ----------
    link
        To the simulator.
    name
        This vehicle.
    rng
        Draws the errors.
    """

    def __init__(self, link: Link, name: str, rng: np.random.Generator) -> None:
        self._link, self._name, self._rng = link, name, rng
        self._reports: defaultdict[str, list[tuple[int, Point]]] = defaultdict(list)
        link.subscribe("body")

    def ranges(self, messages: Iterable[AnyMessage]) -> list[TeammateRange]:
        """Distances to the senders of packets that have just been heard, as they left."""
        for report in self._link.poll():
            if isinstance(report, BodyReport):
                east, north, up = (centimetres / 100.0 for centimetres in report.position_cm)
                reports = self._reports[report.vehicle]
                if not reports or report.stamp_ms > reports[-1][0]:
                    reports.append((report.stamp_ms, (east, north, up)))
                    del reports[:-KEPT_REPORTS]
        found = []
        for message in messages:
            if not isinstance(message, Landmarks) or message.sender == self._name:
                continue
            own, other = self._place(self._name, message.stamp_ms), self._place(message.sender, message.stamp_ms)
            if own is not None and other is not None:
                range_m = noisy_range_m(math.dist(own, other), self._rng)
                found.append(TeammateRange(message.sender, message.sequence, range_m))
        return found

    def _place(self, name: str, stamp_ms: int) -> Point | None:
        """Where a vehicle was, between its two reports around that time."""
        reports = self._reports[name]
        if len(reports) < 2 or not reports[0][0] <= stamp_ms <= reports[-1][0] + AHEAD_MS:
            return None
        later = min(max(1, bisect_left(reports, stamp_ms, key=lambda report: report[0])), len(reports) - 1)
        (before_ms, before), (after_ms, after) = reports[later - 1], reports[later]
        share = (stamp_ms - before_ms) / (after_ms - before_ms)
        east, north, up = (a + share * (b - a) for a, b in zip(before, after, strict=True))
        return (east, north, up)
