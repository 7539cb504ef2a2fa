"""When the mission will be finished, from what every vehicle has achieved so far."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from ground_station.picture import FleetState
from ground_station.vehicle_picture import Condition, VehiclePicture
from vehicle_agent.wire.messages import Stage

MIN_FLOWN_S = 20.0
TAIL = 1.15
"""The last cells lie scattered and cost more than the first."""
WORKING = (Stage.TAKING_OFF, Stage.WORKING)


@dataclass(frozen=True, slots=True)
class Prediction:
    """How much longer, in vehicle time.

    Attributes
    ----------
    remaining_s
        Until the last vehicle is home.
    cut_short
        The mission's time limit comes first.
    """

    remaining_s: float
    cut_short: bool = False


def predict(state: FleetState, without: Iterable[str] = (), joined: Iterable[str] = ()) -> Prediction | None:
    """Time until everything is seen and everybody is home; None while there is not enough to tell.

    Parameters
    ----------
    without
        Vehicles to be left out, as if they were lost.
    joined
        Vehicles to be reckoned with although they do not work now, as if each achieved what the others do on average.
    """
    left_out, coming = frozenset(without), frozenset(joined)
    flown_s = state.elapsed_s
    team = [v for v in state.vehicles if v.name not in left_out and (works(v) or v.name in coming)]
    if flown_s < MIN_FLOWN_S or not team:
        return None
    rates = {vehicle.name: state.team_map.first_seen_cells[vehicle.index] / flown_s for vehicle in team}
    seasoned = [rate for name, rate in rates.items() if name not in coming and rate > 0]
    if not seasoned:
        return None
    average = sum(seasoned) / len(seasoned)
    total = sum(rate if rate > 0 and name not in coming else average for name, rate in rates.items())
    goal = state.plan.mission.stop.observed_fraction * state.team_map.area_cells
    search_s = TAIL * max(0.0, goal - state.team_map.observed_cells) / total
    limit_s = max(0.0, state.plan.mission.stop.time_limit_s - flown_s)
    home_s = max(_way_home_s(state, vehicle) for vehicle in team)
    return Prediction(min(search_s, limit_s) + home_s, search_s > limit_s)


def works(vehicle: VehiclePicture) -> bool:
    """Heard, and on the mission."""
    heard = vehicle.condition in (Condition.LIVE, Condition.SUSPECT)
    return heard and vehicle.status is not None and vehicle.status.stage in WORKING


def _way_home_s(state: FleetState, vehicle: VehiclePicture) -> float:
    if vehicle.status is None:
        return 0.0
    away_m = math.dist(vehicle.status.position_cm[:2], vehicle.status.home_cm[:2]) / 100
    return away_m / state.plan.mission.vehicles[vehicle.index].speed_m_s
