"""A fleet that only talks, for benches of the dashboard: vehicles cross an area, see ground, report once a second."""

from __future__ import annotations

import math
import time
import tomllib

import msgspec
import numpy as np
import numpy.typing as npt

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


def mission_text(vehicles: int, zenoh_port: int = 7_450, replan: str = "ask") -> str:
    """A mission file: a square of 4 km with vehicles in rows at its southern border."""
    team = "".join(
        f"""
[[vehicles]]
name = "vehicle-{number + 1}"
start_enu_m = [{100.0 + 60.0 * (number % 50)}, {100.0 + 60.0 * (number // 50)}]
speed_m_s = {SPEED_M_S}
sensor = {{ kind = "range", range_m = {RANGE_M} }}
min_above_terrain_m = 60.0
max_above_terrain_m = 300.0
"""
        for number in range(vehicles)
    )
    return f"""format = 1
name = "bench"
datum = {{ latitude_deg = 36.654, longitude_deg = -84.37 }}
area = {{ cell_m = {CELL_M}, rectangle_enu_m = [0.0, 0.0, {SIDE_M}, {SIDE_M}] }}
terrain = {{ kind = "flat" }}
task = {{ kind = "explore" }}
radio = {{ zenoh_port = {zenoh_port} }}
replan = {{ mode = "{replan}" }}
{team}"""


def plan_of(vehicles: int) -> MissionPlan:
    """The mission of `mission_text`."""
    return plan_mission(msgspec.convert(tomllib.loads(mission_text(vehicles)), Mission))


class TalkingLink:
    """A link on which every vehicle speaks once per second, each at a moment of its own, as `ground_station.link.Link`.

    Parameters
    ----------
    map_period_s
        Seconds between two pieces of map; 0 for none.
    boot_id
        Of every vehicle's agent; another one is another life.
    """

    undecodable = overflowed = 0

    def __init__(self, plan: MissionPlan, map_period_s: int = 2, boot_id: int = 1) -> None:
        self._plan = plan
        self._map_period_s = map_period_s
        self._boot_id = boot_id
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
        stamp_ms = EPOCH_MS + 1_000 * second
        return {"sender": name, "boot_id": self._boot_id, "sequence": self._sequences[index], "stamp_ms": stamp_ms}

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
        return DeltaRecord(self._plan.vehicle_names[index], self._boot_id, self._records[index] - 1, packed)


def _disc_cells() -> npt.NDArray[np.int64]:
    """(2, N) columns and rows of the cells within a sensor's reach, counted from its own, in the grid's order."""
    reach = int(RANGE_M / CELL_M)
    columns, rows = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1), indexing="ij")
    near = np.hypot(columns, rows) * CELL_M <= RANGE_M
    return np.stack((columns[near], rows[near])).astype(np.int64)


def _cm(place: tuple[float, float]) -> tuple[int, int, int]:
    return (round(100 * place[0]), round(100 * place[1]), 10_000)
