"""Acoustic ranges in lock-step: what a packet's way through the water tells its hearer of the distance."""

from __future__ import annotations

import math

import numpy as np

from sim_bridge.fleet import Fleet
from vehicle_agent.domain.reckoning import noisy_range_m
from vehicle_agent.ports import TeammateRange
from vehicle_agent.wire.messages import AnyMessage, Landmarks

FRESH_MS = 500
"""A packet that waited longer at its sender tells where that was, not where it is."""


class AcousticRanges:
    """Takes a range from every sender to everybody when a packet with a position goes out.

    Parameters
    ----------
    fleet
        Where all truly are.
    rng
        Draws the errors.
    """

    def __init__(self, fleet: Fleet, rng: np.random.Generator) -> None:
        self._fleet, self._rng = fleet, rng
        self._names = fleet.plan.vehicle_names
        self._last: dict[tuple[str, int], list[float]] = {}

    def sent(self, sender: int, message: AnyMessage) -> None:
        """Take ranges now, as the message leaves."""
        if not isinstance(message, Landmarks) or abs(self._fleet.clock.unix_ms - message.stamp_ms) > FRESH_MS:
            return
        places = [vehicle.true_position_enu_m for vehicle in self._fleet.vehicles]
        self._last[self._names[sender], message.sequence] = [
            noisy_range_m(math.dist(place, places[sender]), self._rng) for place in places
        ]

    def heard(self, receiver: int, message: AnyMessage) -> TeammateRange | None:
        """What the receiver's modem makes of a message that has arrived."""
        ranges = self._last.get((message.sender, message.sequence))
        return None if ranges is None else TeammateRange(message.sender, message.sequence, ranges[receiver])
