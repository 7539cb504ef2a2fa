"""The simulated radio: range, loss, delay, capacity, order."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim_bridge.radio import Radio, RadioParams

PLACES = [(0.0, 0.0, 0.0), (100.0, 0.0, 0.0), (0.0, 300.0, 400.0)]


def radio(seed: int = 0, **params: float) -> Radio:
    return Radio(3, RadioParams(**params), np.random.default_rng(seed))


def test_everybody_else_hears_at_once_on_a_perfect_radio() -> None:
    air = radio()
    air.send(0, b"hello", 5.0, PLACES)
    assert air.receive(4.99) == []
    assert sorted(air.receive(5.0)) == [(1, b"hello"), (2, b"hello")]
    assert air.receive(1e9) == []


def test_range_is_measured_in_space_where_the_packet_is_sent() -> None:
    air = radio(range_m=499.9)
    air.send(0, b"a", 0.0, PLACES)
    assert air.receive(0.0) == [(1, b"a")]
    air = radio(range_m=500.0)
    air.send(0, b"a", 0.0, PLACES)
    assert len(air.receive(0.0)) == 2


def test_delay_and_capacity_add_up_and_later_packets_queue() -> None:
    air = radio(delay_s=0.5, rate_bytes_s=100.0)
    air.send(0, bytes(50), 10.0, PLACES[:2])
    air.send(0, bytes(50), 10.0, PLACES[:2])
    air.send(1, bytes(50), 10.0, PLACES[:2])
    arrivals = [t for t in np.arange(10.0, 12.0, 0.01) for receiver, _ in air.receive(t) if receiver == 1]
    assert arrivals == pytest.approx([11.0, 11.5], abs=0.011)
    air.send(0, bytes(50), 20.0, PLACES[:2])
    assert air.receive(20.99) == []
    assert air.receive(21.0) == [(1, bytes(50))]


def test_packets_of_one_sender_arrive_in_order() -> None:
    air = radio(delay_s=0.1)
    for number in range(20):
        air.send(0, bytes([number]), 1.0, PLACES)
    heard = [data[0] for receiver, data in air.receive(2.0) if receiver == 2]
    assert heard == list(range(20))


@pytest.mark.parametrize("loss", [0.05, 0.3, 0.9])
def test_loss_strikes_each_receiver_by_itself_at_its_rate(loss: float) -> None:
    air = radio(loss=loss)
    heard = np.zeros((2_000, 3), dtype=bool)
    for number in range(2_000):
        air.send(0, b"", float(number), PLACES)
        for receiver, _ in air.receive(float(number)):
            heard[number, receiver] = True
    assert heard[:, 1:].mean() == pytest.approx(1.0 - loss, abs=0.03)
    assert np.corrcoef(heard[:, 1], heard[:, 2])[0, 1] == pytest.approx(0.0, abs=0.08)


def test_the_same_seed_loses_the_same_packets() -> None:
    def heard(seed: int) -> list[int]:
        air = radio(seed, loss=0.5)
        for number in range(50):
            air.send(0, bytes([number]), 0.0, PLACES[:2])
        return [data[0] for _, data in air.receive(1.0)]

    assert heard(1) == heard(1)
    assert heard(1) != heard(2)


@pytest.mark.parametrize(
    "wrong",
    [
        {"loss": 1.0},
        {"loss": -0.1},
        {"loss": math.nan},
        {"delay_s": -1.0},
        {"rate_bytes_s": 0.0},
        {"rate_bytes_s": math.nan},
    ],
)
def test_impossible_radios_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must"):
        RadioParams(**wrong)
