"""The fleet that talks to the dashboard's bench is one that the ground station believes, and memory stays flat."""

from __future__ import annotations

from ground_station.fleet_state import MAX_LOG_ENTRIES
from ground_station.samples import MAX_TRAIL_POINTS
from ground_station.station import Station
from missions.bench.talking_fleet import TalkingLink, plan_of
from vehicle_agent.wire.messages import Event


def test_what_the_talking_fleet_says_is_taken_in_whole() -> None:
    plan = plan_of(3)
    link = TalkingLink(plan)
    station = Station(plan, "station-0001", 1, 0.0)
    station.attach(link)
    said = link.until(60)
    link.poll = lambda: said  # type: ignore[method-assign]
    state = station.step(1.0)
    assert state.counters.bad == 0
    assert state.elapsed_s == 60.0
    assert 0.05 < state.team_map.coverage < 0.9
    assert all(len(vehicle.trail_en_m) > 5 and vehicle.claim is not None for vehicle in state.vehicles)


def test_ten_thousand_events_a_second_and_endless_trails_stay_bounded() -> None:
    plan = plan_of(2)
    station = Station(plan, "station-0001", 1, 0.0)
    link = TalkingLink(plan, map_period_s=0)
    station.attach(link)
    for second in range(4):
        flood = [
            event
            for number in range(10_000)
            for event in link.say(0, 20 * (10_000 * second + number))
            if isinstance(event, Event)
        ]
        assert len(flood) == 10_000
        link.poll = lambda flood=flood: flood  # type: ignore[method-assign, misc]
        state = station.step(float(second))
    assert state.log_total >= 40_000
    assert len(state.log) == MAX_LOG_ENTRIES
    link.poll = lambda: link.until(4_000)  # type: ignore[method-assign]
    link.skip_to(0)
    state = station.step(9.0)
    assert all(len(vehicle.trail_en_m) <= MAX_TRAIL_POINTS for vehicle in state.vehicles)
