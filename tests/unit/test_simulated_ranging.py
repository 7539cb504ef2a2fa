"""A simulated modem's ranges: as far apart as bodies were when a packet left, nothing of where they were."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.adapters.simulated_ranging import SimulatedRanging
from vehicle_agent.wire.messages import AnyMessage, BodyReport, Landmarks


class Simulator:
    """The simulator's side of a link."""

    def __init__(self) -> None:
        self.said: list[AnyMessage] = []

    def subscribe(self, topic_name: str, participant: str = "*") -> None:
        assert topic_name == "body"

    def poll(self) -> list[AnyMessage]:
        said, self.said = self.said, []
        return said


def body(vehicle: str, stamp_ms: int, east_m: float) -> BodyReport:
    return BodyReport(
        sender="simulator", boot_id=1, sequence=stamp_ms, stamp_ms=stamp_ms, vehicle=vehicle,
        position_cm=(round(100 * east_m), 0, -200), armed=True, has_flown=True, crashed=False, mode="GUIDED",
    )  # fmt: skip


def packet(stamp_ms: int, sequence: int = 1) -> Landmarks:
    return Landmarks(
        sender="brisa", boot_id=1, sequence=sequence, stamp_ms=stamp_ms, position_cm=(0, 0, 0), position_sd_cm=100,
        records=b"",
    )  # fmt: skip


def ranging(*reports: BodyReport, seed: int = 0) -> SimulatedRanging:
    simulator = Simulator()
    simulator.said += reports
    return SimulatedRanging(simulator, "alba", np.random.default_rng(seed))


MOVING = (body("alba", 1_000, 0.0), body("brisa", 1_000, 40.0), body("alba", 2_000, 2.0), body("brisa", 2_000, 60.0))


def test_ranges_are_those_of_the_moment_at_which_the_packet_left() -> None:
    measured = [ranging(*MOVING, seed=seed).ranges([packet(1_500, sequence=9)])[0] for seed in range(200)]
    assert {(one.sender, one.sequence) for one in measured} == {("brisa", 9)}
    assert np.mean([one.range_m for one in measured]) == pytest.approx(49.0, abs=0.3)
    assert np.std([one.range_m for one in measured]) == pytest.approx(1.0, abs=0.25)


def test_no_range_comes_from_before_or_long_after_what_the_simulator_told() -> None:
    modem = ranging(*MOVING)
    assert modem.ranges([packet(500)]) == []
    assert modem.ranges([packet(9_000)]) == []
    assert len(modem.ranges([packet(2_800)])) == 1


def test_own_packets_and_unknown_bodies_have_no_range() -> None:
    assert ranging(*MOVING[::2]).ranges([packet(1_500)]) == []
