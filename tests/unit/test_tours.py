"""Tours by given distances: everybody's work is somebody's once, and the longest tour is near the shortest possible."""

from __future__ import annotations

from itertools import pairwise, permutations

import numpy as np
import pytest

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.tours import share_out


def distances(points: FloatArray) -> FloatArray:
    away: FloatArray = np.linalg.norm(points[:, None] - points[None], axis=2)
    return away


def length(away: FloatArray, tour: list[int]) -> float:
    return float(sum(away[one, other] for one, other in pairwise(tour)))


def best_longest(away: FloatArray, service: FloatArray) -> float:
    """The least longest tour of two vehicles, by trying all."""
    places = len(service)
    least = np.inf
    for order in permutations(range(places)):
        for cut in range(places + 1):
            own = [[vehicle, *(2 + place for place in part)] for vehicle, part in enumerate((order[:cut], order[cut:]))]
            work = [float(service[list(part)].sum()) for part in (order[:cut], order[cut:])]
            least = min(least, max(length(away, tour) + work[vehicle] for vehicle, tour in enumerate(own)))
    return least


@pytest.mark.parametrize("seed", range(4))
def test_every_place_is_in_one_tour_and_the_longest_is_near_the_best(seed: int) -> None:
    rng = np.random.default_rng(seed)
    away = distances(rng.uniform(0.0, 50.0, (2 + 6, 3)))
    service = rng.uniform(0.0, 10.0, 6)
    tours, lengths = share_out(away, np.zeros(2), service, 20)
    shared = [tours[vehicle, : lengths[vehicle]].tolist() for vehicle in range(2)]
    assert sorted(shared[0] + shared[1]) == list(range(6))
    longest = max(
        length(away, [vehicle, *(2 + place for place in tour)]) + float(service[tour].sum())
        for vehicle, tour in enumerate(shared)
    )
    assert longest <= 1.25 * best_longest(away, service)


def test_who_still_has_far_to_go_is_given_less() -> None:
    places = np.column_stack((np.arange(10.0, 70.0, 10.0), np.zeros(6)))
    away = distances(np.concatenate((np.zeros((2, 2)), places)))
    tours, lengths = share_out(away, np.array([200.0, 0.0]), np.zeros(6), 20)
    assert lengths.tolist() == [0, 6]
    assert tours[1].tolist() == list(range(6))


def test_no_places_make_empty_tours() -> None:
    _, lengths = share_out(np.zeros((3, 3)), np.zeros(3), np.zeros(0), 20)
    assert lengths.tolist() == [0, 0, 0]


def test_ways_count_and_not_where_places_lie() -> None:
    away = np.array([[0.0, 1.0, 9.0, 2.0], [1.0, 0.0, 1.0, 9.0], [9.0, 1.0, 0.0, 1.0], [2.0, 9.0, 1.0, 0.0]])
    tours, lengths = share_out(away, np.zeros(1), np.zeros(3), 20)
    assert lengths.tolist() == [3]
    assert tours[0].tolist() == [0, 1, 2]
