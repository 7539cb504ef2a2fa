"""A simulated vehicle's poor radio: the loss, delay and range that the mission file states, around a good link."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Collection
from itertools import count

import numpy as np

from vehicle_agent.mission.model import RadioTable
from vehicle_agent.ports import Team
from vehicle_agent.wire.messages import AnyMessage, Landmarks, Status

SPAWN_KEY = 2_100


class PoorRadio:
    """A `Team` that hears its teammates late, not always and not from afar; stations are heard as they are.

    Parameters
    ----------
    team
        The good link.
    radio
        `loss`, `delay_s` and `range_m` count. Where a vehicle is, is known from what it said last.
    teammates
        Names of those whose words suffer.
    clock
        Seconds in which the delay is counted: the vehicle's.
    rng
        Decides what is lost.

    Attributes
    ----------
    lost, heard
        Teammates' messages that were lost and that arrived so far.
    """

    def __init__(
        self,
        team: Team,
        radio: RadioTable,
        teammates: Collection[str],
        clock: Callable[[], float],
        rng: np.random.Generator,
    ) -> None:
        self._team, self._radio, self._teammates = team, radio, frozenset(teammates)
        self._clock, self._rng = clock, rng
        self._under_way: list[tuple[float, int, AnyMessage]] = []
        self._numbers = count()
        self._places_cm: dict[str, tuple[int, int, int]] = {}
        self._here_cm: tuple[int, int, int] | None = None
        self.lost = self.heard = 0

    def poll(self) -> list[AnyMessage]:
        now_s, arrived = self._clock(), []
        for message in self._team.poll():
            if message.sender not in self._teammates:
                arrived.append(message)
            elif self._is_lost(message):
                self.lost += 1
            else:
                arrives_s = now_s + self._radio.delay_s
                heapq.heappush(self._under_way, (arrives_s, next(self._numbers), message))
        while self._under_way and self._under_way[0][0] <= now_s:
            arrived.append(heapq.heappop(self._under_way)[2])
            self.heard += 1
        return arrived

    def publish(self, message: AnyMessage) -> None:
        if isinstance(message, (Status, Landmarks)):
            self._here_cm = message.position_cm
        self._team.publish(message)

    def _is_lost(self, message: AnyMessage) -> bool:
        if isinstance(message, (Status, Landmarks)):
            self._places_cm[message.sender] = message.position_cm
        there_cm, range_m = self._places_cm.get(message.sender), self._radio.range_m
        is_lost = bool(self._rng.random() < self._radio.loss)
        if range_m is None or self._here_cm is None or there_cm is None:
            return is_lost
        return is_lost or math.dist(self._here_cm, there_cm) > 100.0 * range_m


def is_poor(radio: RadioTable) -> bool:
    """Whether a mission states a radio that loses, delays or does not reach."""
    return radio.loss > 0.0 or radio.delay_s > 0.0 or radio.range_m is not None
