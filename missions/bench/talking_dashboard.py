"""The dashboard over a fleet that only talks: on a terminal for its bench, and without one for hours on end."""

from __future__ import annotations

import sys
import time

from ground_station.app import GroundStationApp, run_on_terminal
from ground_station.picture import FleetState
from ground_station.station import Station
from ground_station.views.ink import Look
from missions.bench.talking_fleet import TalkingLink, plan_of


def resident_bytes() -> int:
    """Memory of this process that is in use now."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4_096


def talk_for_hours(vehicles: int, hours: int, period_s: int = 5) -> list[int]:
    """Resident bytes after every hour of a fleet whose statuses are heard every `period_s` seconds."""
    plan = plan_of(vehicles)
    link = TalkingLink(plan, map_period_s=40)
    station = Station(plan, "station-0001", 1, 0.0)
    station.attach(link)
    link.poll = list  # type: ignore[method-assign]
    sizes = []
    state: FleetState = station.state
    for second in range(0, 3_600 * hours, period_s):
        link.skip_to(second)
        spoken = link.until(second)
        link.poll = lambda spoken=spoken: spoken  # type: ignore[method-assign, misc]
        state = station.step(float(second))
        if second % 3_600 == 3_600 - period_s:
            sizes.append(resident_bytes())
    assert state.heard_any
    return sizes


def main() -> None:
    """`python -m missions.bench.talking_dashboard VEHICLES`: the dashboard over such a fleet on this terminal."""
    plan = plan_of(int(sys.argv[1]))
    station = Station(plan, "station-0001", 1, time.monotonic())
    run_on_terminal(GroundStationApp(station, lambda: TalkingLink(plan), Look()))


if __name__ == "__main__":
    main()
