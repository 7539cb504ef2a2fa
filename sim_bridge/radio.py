"""The radio between simulated vehicles: seeded loss, delay, range and capacity per sender."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import Point


@dataclass(frozen=True, slots=True)
class RadioParams:
    """What the radio does to a packet.

    Attributes
    ----------
    range_m
        Packets reach receivers within this distance; None reaches everybody.
    loss
        Probability in [0, 1) that one receiver misses one packet.
    delay_s
        Time from the end of sending to reception.
    rate_bytes_s
        What one sender gets through per second; later packets queue behind earlier ones.
    """

    range_m: float | None = None
    loss: float = 0.0
    delay_s: float = 0.0
    rate_bytes_s: float = math.inf

    def __post_init__(self) -> None:
        if not 0.0 <= self.loss < 1.0:
            raise ValueError("loss must lie in [0, 1)")
        if self.delay_s < 0.0 or not self.rate_bytes_s > 0.0:
            raise ValueError("delay_s must not be negative and rate_bytes_s must be positive")


class Radio:
    """Carries byte strings between numbered participants."""

    def __init__(self, participants: int, params: RadioParams, rng: np.random.Generator) -> None:
        self._params = params
        self._rng = rng
        self._free_at_s = [0.0] * participants
        self._in_flight: list[tuple[float, int, int, bytes]] = []
        self._count = 0

    def send(self, sender: int, data: bytes, now_s: float, positions_enu_m: list[Point]) -> None:
        """Send to everybody in reach of the sender's present position."""
        params = self._params
        start_s = max(now_s, self._free_at_s[sender])
        self._free_at_s[sender] = start_s + len(data) / params.rate_bytes_s
        arrival_s = self._free_at_s[sender] + params.delay_s
        for receiver, position in enumerate(positions_enu_m):
            if receiver == sender:
                continue
            if params.range_m is not None and math.dist(position, positions_enu_m[sender]) > params.range_m:
                continue
            if params.loss > 0.0 and self._rng.random() < params.loss:
                continue
            self._count += 1
            heapq.heappush(self._in_flight, (arrival_s, self._count, receiver, data))

    def receive(self, now_s: float) -> list[tuple[int, bytes]]:
        """Take what has arrived by now: (receiver, bytes) in order of arrival."""
        arrived = []
        while self._in_flight and self._in_flight[0][0] <= now_s:
            _, _, receiver, data = heapq.heappop(self._in_flight)
            arrived.append((receiver, data))
        return arrived
