"""How a team's tours are mended, and how announcements that contradict each other come together."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.shared_tours import mend_tours
from vehicle_agent.planning.interface import AnnouncedTour
from vehicle_agent.planning.patches import Stops
from vehicle_agent.planning.team_tours import LAST_NUMBER, Tourist, announced_order, own_tour


def walk(next_of: IndexArray, vehicle: int) -> list[int]:
    order, place = [], int(next_of[vehicle])
    while place >= 0:
        order.append(place)
        place = int(next_of[place])
    return order


def length(points: FloatArray, vehicle: int, order: list[int]) -> float:
    return sum(math.dist(points[a], points[b]) for a, b in itertools.pairwise([vehicle, *order]))


def mend(points: FloatArray, vehicles: int, trials: int, way_back: float = 0.0) -> tuple[IndexArray, FloatArray]:
    next_of = np.full(len(points), -1, dtype=np.int64)
    homes = points[:vehicles].copy()
    lengths = mend_tours(points, homes, way_back, np.zeros(len(points)), next_of, trials, 5, 1)
    return next_of, lengths


@pytest.mark.parametrize("way_back", [0.0, 1.0])
def test_every_place_is_in_one_tour_and_lengths_are_those_flown(way_back: float) -> None:
    points = np.random.default_rng(3).uniform(0.0, 100.0, (33, 2))
    next_of, lengths = mend(points, 3, 200, way_back)
    tours = [walk(next_of, vehicle) for vehicle in range(3)]
    assert sorted(itertools.chain(*tours)) == list(range(3, 33))
    for vehicle, tour in enumerate(tours):
        back = way_back * math.dist(points[tour[-1]], points[vehicle])
        assert lengths[vehicle] == pytest.approx(length(points, vehicle, tour) + back)


def test_trials_shorten_the_longest_tour() -> None:
    gains = []
    for seed in range(8):
        points = np.random.default_rng(seed).uniform(0.0, 100.0, (44, 2))
        at_once, mended = (mend(points, 4, trials)[1].max() for trials in (0, 300))
        gains.append(mended / at_once)
    assert max(gains) < 1.03  # what counts is the eighth power of every tour
    assert np.mean(gains) < 0.97


def test_two_vehicles_part_two_heaps_between_them() -> None:
    heaps = [(float(x), float(y)) for x in (0, 100) for y in range(0, 50, 10)]
    points = np.array([(50.0, 0.0), (50.0, 5.0), *heaps])
    next_of, _ = mend(points, 2, 200)
    for vehicle in range(2):
        assert len({points[place][0] for place in walk(next_of, vehicle)}) == 1


def line_of_stops(count: int) -> Stops:
    centres = np.column_stack((10.0 * np.arange(count), np.zeros(count)))
    return Stops(np.arange(count), centres, np.full(count, 100))


def test_the_later_announcement_holds_a_patch_that_two_announced() -> None:
    team = [
        Tourist(0, (0.0, 0.0, 5.0), AnnouncedTour(4, (1, 2))),
        Tourist(3, (0.0, 5.0, 5.0), AnnouncedTour(7, (2, 0, 9))),
    ]
    next_of = announced_order(team, np.arange(4))
    assert walk(next_of, 0) == [2 + 1]
    assert walk(next_of, 1) == [2 + 2, 2 + 0]  # 9 has been seen meanwhile, 3 nobody announced


def test_teammates_who_hear_each_other_share_all_patches_out() -> None:
    patches = line_of_stops(12)
    places = {0: (0.0, 0.0, 5.0), 1: (110.0, 0.0, 5.0)}
    tours: dict[int, AnnouncedTour | None] = {0: None, 1: None}
    for index in (0, 1, 0, 1):
        team = [Tourist(i, places[i], tours[i]) for i in places]
        tours[index] = own_tour(team, index, patches, np.zeros(12), None, 50, 4)
    west, east = (tour.patches for tour in tours.values() if tour is not None)
    assert sorted(west + east) == list(range(12))
    assert (west, east) == ((0, 1, 2, 3, 4, 5), (11, 10, 9, 8, 7, 6))


def test_a_tour_that_stays_is_not_announced_anew_and_numbers_do_not_overflow() -> None:
    patches = line_of_stops(3)
    last = AnnouncedTour(LAST_NUMBER, ())
    team = [Tourist(0, (-5.0, 0.0, 5.0), None), Tourist(1, (900.0, 0.0, 5.0), last)]
    first = own_tour(team, 0, patches, np.zeros(3), None, 10, 4)
    assert first == AnnouncedTour(LAST_NUMBER, (0, 1, 2))
    again = own_tour([Tourist(0, (-4.0, 0.0, 5.0), first), team[1]], 0, patches, np.zeros(3), None, 10, 4)
    assert again is first
