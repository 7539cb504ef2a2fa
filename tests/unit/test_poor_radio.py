"""A poor radio between simulated vehicles: what is lost, late or too far, and what is spared."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.adapters.poor_radio import PoorRadio, is_poor
from vehicle_agent.mission.model import RadioTable
from vehicle_agent.wire.messages import AnyMessage, Landmarks, Orders


class GoodRadio:
    """A `Team` that loses nothing."""

    def __init__(self) -> None:
        self.arrived: list[AnyMessage] = []
        self.said: list[AnyMessage] = []

    def poll(self) -> list[AnyMessage]:
        arrived, self.arrived = self.arrived, []
        return arrived

    def publish(self, message: AnyMessage) -> None:
        self.said.append(message)


def words(sender: str, sequence: int, east_m: float = 0.0) -> Landmarks:
    return Landmarks(
        sender=sender, boot_id=1, sequence=sequence, stamp_ms=0, position_cm=(round(100 * east_m), 0, -200),
        position_sd_cm=100, records=b"",
    )  # fmt: skip


class Water:
    """A poor radio, its good link and a clock to turn."""

    def __init__(self, seed: int = 0, **radio: float) -> None:
        self.link, self.now_s = GoodRadio(), 100.0
        rng = np.random.default_rng(seed)
        self.radio = PoorRadio(self.link, RadioTable(**radio), ["brisa"], lambda: self.now_s, rng)  # type: ignore[arg-type]

    def hear(self, *messages: AnyMessage) -> list[int]:
        self.link.arrived += messages
        return [message.sequence for message in self.radio.poll()]


def test_words_of_teammates_come_late_by_the_vehicles_clock_and_in_order() -> None:
    water = Water(delay_s=2.0)
    assert water.hear(words("brisa", 1), words("brisa", 2)) == []
    water.now_s = 101.0
    assert water.hear(words("brisa", 3)) == []
    water.now_s = 102.0
    assert water.hear() == [1, 2]
    water.now_s = 103.0
    assert water.hear() == [3]


def test_so_many_are_lost_and_the_same_ones_for_the_same_seed() -> None:
    runs = []
    for seed in (4, 4, 5):
        water = Water(seed, loss=0.3)
        runs.append([number for number in range(2_000) if water.hear(words("brisa", number))])
        assert water.radio.lost == 2_000 - len(runs[-1])
    assert len(runs[0]) == pytest.approx(1_400, abs=100)
    assert runs[0] == runs[1] != runs[2]


def test_stations_are_heard_at_once_and_nothing_said_is_lost_here() -> None:
    water = Water(loss=0.99, delay_s=5.0)
    station = Orders(
        sender="station-1",
        boot_id=1,
        sequence=7,
        stamp_ms=0,
    )
    assert water.hear(station) == [7]
    for number in range(20):
        water.radio.publish(words("alba", number))
    assert len(water.link.said) == 20


def test_who_is_too_far_is_not_heard() -> None:
    water = Water(range_m=50.0)
    water.radio.publish(words("alba", 1, east_m=0.0))
    assert water.hear(words("brisa", 1, east_m=49.0)) == [1]
    assert water.hear(words("brisa", 2, east_m=51.0)) == []
    water.radio.publish(words("alba", 2, east_m=10.0))
    assert water.hear(words("brisa", 3, east_m=51.0)) == [3]


def test_a_mission_without_such_words_has_a_good_radio() -> None:
    assert not is_poor(RadioTable())
    assert is_poor(RadioTable(loss=0.1))
    assert is_poor(RadioTable(delay_s=0.5))
    assert is_poor(RadioTable(range_m=300.0))
