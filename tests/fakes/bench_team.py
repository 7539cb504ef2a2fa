"""Several agents on a bench that hear each other, and how near they come to each other in the air."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import combinations

from tests.fakes.agent_bench import AgentBench
from tests.fakes.sim_missions import GROUND_M
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.messages import AnyMessage, Status

IN_AIR_M = 1.0


class BenchTeam:
    """Steps agents of one mission together; what one says the others hear at the next tick.

    Attributes
    ----------
    benches
        By team index.
    closest_m
        Least distance of two vehicles in the air so far.
    """

    def __init__(self, plan: MissionPlan) -> None:
        self.benches = [AgentBench(plan, index, boot_id=5 + index) for index in range(len(plan.mission.vehicles))]
        self.closest_m = math.inf

    def tick(self) -> None:
        told: list[tuple[int, AnyMessage]] = []
        for index, bench in enumerate(self.benches):
            told += [(index, message) for message in bench.tick().messages]
        for index, bench in enumerate(self.benches):
            bench.hear(*(message for sender, message in told if sender != index))
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
