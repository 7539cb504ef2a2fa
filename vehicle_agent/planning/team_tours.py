"""The team's tours over patches, put together from what every vehicle announced of its own and mended a little."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.shared_tours import mend_tours
from vehicle_agent.planning.interface import AnnouncedTour
from vehicle_agent.planning.patches import Stops

LAST_NUMBER = 2**32 - 1


@dataclass(frozen=True, slots=True)
class Tourist:
    """One vehicle of the team as tours see it: where it is, and which tour it announced last."""

    index: int
    position_enu_m: Point
    tour: AnnouncedTour | None


def own_tour(
    team: Sequence[Tourist], own_index: int, stops: Stops, service_m: FloatArray, home_en_m: FloatArray | None,
    trials: int, most_taken: int,
) -> AnnouncedTour:  # fmt: skip
    """This vehicle's part of the mended tours.

    What two announced belongs to the later announcement; numbers count announcements as in Lamport's clocks, so that
    nobody needs the time. What nobody announced goes where it costs least.

    Parameters
    ----------
    team : every vehicle, by index.
    stops : all that are to be visited.
    service_m : (P,) float64, extra way that each costs.
    home_en_m : (2,) float64, where vehicles return to; None when they need not.
    trials, most_taken : as for `mend_tours`.
    """
    vehicles = len(team)
    starts = np.array([member.position_enu_m[:2] for member in team])
    points = np.concatenate((starts, stops.places_en_m))
    next_of = announced_order(team, stops.numbers)
    number = min(1 + max(member.tour.number if member.tour else 0 for member in team), LAST_NUMBER)
    homes = starts if home_en_m is None else np.tile(home_en_m, (vehicles, 1))
    mend_tours(
        points, homes, 0.0 if home_en_m is None else 1.0, np.concatenate((np.zeros(vehicles), service_m)), next_of,
        trials, most_taken, number % 1_000_000,
    )  # fmt: skip
    mine = [member.index for member in team].index(own_index)
    place = int(next_of[mine])
    own = []
    while place >= 0:
        own.append(int(stops.numbers[place - vehicles]))
        place = int(next_of[place])
    before = team[mine].tour
    return before if before is not None and before.patches == tuple(own) else AnnouncedTour(number, tuple(own))


def announced_order(team: Sequence[Tourist], numbers: IndexArray) -> IndexArray:
    """What comes after each vehicle and patch by the announcements: (N + P,) int64, -1 at ends and for free patches."""
    vehicles = len(team)
    place_of = {int(number): vehicles + place for place, number in enumerate(numbers)}
    next_of = np.full(vehicles + len(numbers), -1, dtype=np.int64)
    taken: set[int] = set()
    latest_first = sorted(range(vehicles), key=lambda n: (-(t.number if (t := team[n].tour) else 0), team[n].index))
    for vehicle in latest_first:
        before = vehicle
        tour = team[vehicle].tour
        for number in tour.patches if tour else ():
            place = place_of.get(number)
            if place is None or place in taken:
                continue
            taken.add(place)
            next_of[before] = place
            before = place
    return next_of
