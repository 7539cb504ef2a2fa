"""Several agents on a bench that hear each other, and how near they come to each other in the air."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import combinations

import numpy as np

from tests.fakes.agent_bench import AgentBench
from tests.fakes.sim_missions import GROUND_M
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.messages import AnyMessage, Status

IN_AIR_M = 1.0


class BenchTeam:
    """Steps agents of one mission together; what one says the others hear at the next tick, or later, or never.

    Parameters
    ----------
    delay_s, loss, seed
        How late words are heard, and which share of them not at all, drawn with a seed.

    Attributes
    ----------
    benches
        By team index.
    closest_m
        Least distance of two vehicles in the air so far.
    """

    def __init__(self, plan: MissionPlan, delay_s: float = 0.0, loss: float = 0.0, seed: int = 0) -> None:
        self._delay_s, self._loss, self._rng = delay_s, loss, np.random.default_rng(seed)
        self._under_way: list[tuple[float, int, AnyMessage]] = []
        self.benches = [AgentBench(plan, index, boot_id=5 + index) for index in range(len(plan.mission.vehicles))]
        self.closest_m = math.inf

    def tick(self) -> None:
        for sender, bench in enumerate(self.benches):
            for message in bench.tick().messages:
                receivers = [index for index in range(len(self.benches)) if index != sender]
                heard = [index for index in receivers if self._rng.random() >= self._loss]
                self._under_way += [(bench.time_s + self._delay_s, index, message) for index in heard]
        now_s = self.benches[0].time_s
        arrived = [told for told in self._under_way if told[0] <= now_s]
        self._under_way = [told for told in self._under_way if told[0] > now_s]
        for _, receiver, message in arrived:
            self.benches[receiver].hear(message)
        flying = [b.state.position_enu_m for b in self.benches if b.state.position_enu_m[2] > GROUND_M + IN_AIR_M]
        for one, other in combinations(flying, 2):
            self.closest_m = min(self.closest_m, math.dist(one, other))

    def run(self, seconds: float) -> None:
        for _ in range(round(2.0 * seconds)):
            self.tick()

    def run_until(self, condition: Callable[[], bool], limit_s: float = 600.0) -> None:
        """Run until the condition holds; fails after so much simulated time."""
        for _ in range(round(2.0 * limit_s)):
            if condition():
                return
            self.tick()
        told = [f"{b.agent.name}: {b.agent.stage.name}, {b.said(Status)[-1].why}" for b in self.benches]
        raise AssertionError(f"not within {limit_s} s; {'; '.join(told)}")
