"""A fleet that only talks, for benches of the dashboard: vehicles cross an area, see ground, report once a second."""

from __future__ import annotations

import math
import sys
import time

import msgspec
import numpy as np
import numpy.typing as npt

from ground_station.app import GroundStationApp, run_on_terminal
from ground_station.picture import FleetState
from ground_station.station import Station
from ground_station.views.ink import Look
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.mission.load import MissionPlan, plan_mission
from vehicle_agent.mission.model import Mission
from vehicle_agent.wire.cells import pack_cells
from vehicle_agent.wire.messages import AnyMessage, Claim, DeltaRecord, Event, MapDelta, Severity, Stage, Status

EPOCH_MS = 1_767_225_600_000
SIDE_M = 4_000.0
CELL_M = 20.0
RANGE_M = 350.0
SPEED_M_S = 18.0
EVENT_PERIOD_S = 20
"""Every vehicle says something now and then."""


def plan_of(vehicles: int) -> MissionPlan:
    """A square of 4 km with vehicles in rows at its southern border."""
    content = {
        "format": 1,
        "name": "bench",
        "datum": {"latitude_deg": 36.654, "longitude_deg": -84.37},
        "area": {"cell_m": CELL_M, "rectangle_enu_m": [0.0, 0.0, SIDE_M, SIDE_M]},
        "terrain": {"kind": "flat"},
        "task": {"kind": "explore"},
        "vehicles": [
            {
                "name": f"vehicle-{number + 1}",
                "start_enu_m": [100.0 + 60.0 * (number % 50), 100.0 + 60.0 * (number // 50)],
                "speed_m_s": SPEED_M_S,
                "sensor": {"kind": "range", "range_m": RANGE_M},
                "min_above_terrain_m": 60.0,
                "max_above_terrain_m": 300.0,
            }
            for number in range(vehicles)
        ],
    }
    return plan_mission(msgspec.convert(content, Mission))


class TalkingLink:
    """A link on which every vehicle speaks once per second, each at a moment of its own, as `ground_station.link.Link`.

    Parameters
    ----------
    map_period_s
        Seconds between two pieces of map; 0 for none.
    """

    undecodable = overflowed = 0

    def __init__(self, plan: MissionPlan, map_period_s: int = 2) -> None:
        self._plan = plan
        self._map_period_s = map_period_s
        self._sequences = [0] * len(plan.vehicle_names)
        self._records = [0] * len(plan.vehicle_names)
        self._said = 0
        self._began_s: float | None = None
        self._disc = _disc_cells()
        self.counters = self

    def poll(self) -> list[AnyMessage]:
        now_s = time.monotonic()
        self._began_s = now_s if self._began_s is None else self._began_s
        return self._until_turn(int((now_s - self._began_s) * len(self._plan.vehicle_names)))

    def until(self, second: int) -> list[AnyMessage]:
        """Everything said up to and with a second that was not polled before."""
        return self._until_turn((second + 1) * len(self._plan.vehicle_names))

    def skip_to(self, second: int) -> None:
        """Leave out what would have been said before a second."""
        self._said = second * len(self._plan.vehicle_names)

    def _until_turn(self, turn: int) -> list[AnyMessage]:
        said: list[AnyMessage] = []
        while self._said < turn:
            second, index = divmod(self._said, len(self._plan.vehicle_names))
            said += self.say(index, second)
            self._said += 1
        return said

    def poll_alive(self) -> list[tuple[str, bool]]:
        return []

    def publish(self, message: AnyMessage) -> None:
        """Nobody listens."""

    def close(self) -> None:
        """Nothing is open."""

    def _place(self, index: int, second: int) -> tuple[float, float]:
        """Up and down along a column of its own, the columns drifting east."""
        lanes = len(self._plan.vehicle_names)
        way = (SPEED_M_S * second) % (2 * (SIDE_M - 200))
        north_m = 100 + min(way, 2 * (SIDE_M - 200) - way)
        east_m = 100 + (SIDE_M - 200) * ((index + 0.5) / lanes + second / 20_000) % (SIDE_M - 200)
        return (east_m, north_m)

    def _head(self, index: int, second: int) -> dict[str, object]:
        self._sequences[index] += 1
        name = self._plan.vehicle_names[index]
        return {"sender": name, "boot_id": 1, "sequence": self._sequences[index], "stamp_ms": EPOCH_MS + 1_000 * second}

    def say(self, index: int, second: int) -> list[AnyMessage]:
        """What one vehicle says in one second."""
        here, there = self._place(index, second), self._place(index, second + 10)
        goal = self._place(index, second + 40)
        said: list[AnyMessage] = [
            Status(
                **self._head(index, second),  # type: ignore[arg-type]
                stage=Stage.WORKING,
                mode="guided",
                armed=True,
                position_cm=_cm(here),
                velocity_cm_s=(0, 1_800, 0),
                heading_deg=round(math.degrees(math.atan2(there[0] - here[0], there[1] - here[1]))) % 360,
                battery_permille=max(0, 990 - second // 60),
                leg_end_cm=_cm(there),
                home_cm=_cm((100.0 + 60.0 * index, 100.0)),
                known_permille=0,
                first_seen_cells=second,
                bytes_sent=400 * second,
                messages_dropped=0,
                why=f"unseen patch {400 + 7 * (second % 50)} m N, first of {1 + second % 17} in its tour",
                path_cm=(_cm(goal),),
            )
        ]
        if second % 10 == index % 10:
            said.append(Claim(**self._head(index, second), active=True, goal_cm=_cm(goal), cost_m=500))  # type: ignore[arg-type]
        if second % EVENT_PERIOD_S == index % EVENT_PERIOD_S:
            text = f"note {second} of a mission that goes on"
            said.append(Event(**self._head(index, second), severity=Severity.INFO, code="note", text=text))  # type: ignore[arg-type]
        if self._map_period_s and second % self._map_period_s == index % self._map_period_s:
            record = self._record(index, here, second)
            said.append(MapDelta(**self._head(index, second), record=record))  # type: ignore[arg-type]
        return said

    def _record(self, index: int, here: tuple[float, float], second: int) -> DeltaRecord:
        grid = self._plan.grid
        columns, rows = (self._disc[at] + int(here[at] / CELL_M) for at in (0, 1))
        inside = (columns >= 0) & (columns < grid.columns) & (rows >= 0) & (rows < grid.rows)
        columns, rows = columns[inside], rows[inside]
        cells = columns * grid.rows + rows
        heights = (4_000 + 10 * columns + 5 * rows).astype(np.int32)
        stamps = np.full(len(cells), EPOCH_MS + 1_000 * second, dtype=np.int64)
        self._records[index] += 1
        packed = pack_cells(CellObservations(cells, heights, stamps))
        return DeltaRecord(self._plan.vehicle_names[index], 1, self._records[index] - 1, packed)


def _disc_cells() -> npt.NDArray[np.int64]:
    """(2, N) columns and rows of the cells within a sensor's reach, counted from its own, in the grid's order."""
    reach = int(RANGE_M / CELL_M)
    columns, rows = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1), indexing="ij")
    near = np.hypot(columns, rows) * CELL_M <= RANGE_M
    return np.stack((columns[near], rows[near])).astype(np.int64)


def _cm(place: tuple[float, float]) -> tuple[int, int, int]:
    return (round(100 * place[0]), round(100 * place[1]), 10_000)


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
    """`python -m missions.bench.talking_fleet VEHICLES`: the dashboard over such a fleet on this terminal."""
    plan = plan_of(int(sys.argv[1]))
    station = Station(plan, "station-0001", 1, time.monotonic())
    run_on_terminal(GroundStationApp(station, lambda: TalkingLink(plan), Look()))


if __name__ == "__main__":
    main()
