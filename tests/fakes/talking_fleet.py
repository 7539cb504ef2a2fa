"""A fleet that only talks: a small mission, well-formed messages of its vehicles, and a link made of lists."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np

from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.mission.load import MissionPlan, plan_mission
from vehicle_agent.mission.model import Mission
from vehicle_agent.wire.cells import pack_cells
from vehicle_agent.wire.messages import (
    AnyMessage,
    Claim,
    Command,
    CommandResult,
    DeltaRecord,
    Digest,
    Event,
    MapDelta,
    Outcome,
    Repair,
    Severity,
    Stage,
    Status,
    StreamHeld,
)

EPOCH_MS = 1_767_225_600_000
NAMES = ("merlin", "kestrel", "osprey", "harrier")


def small_plan(vehicles: int = 4) -> MissionPlan:
    """A 200 m square of 10 m cells; the first four vehicles are merlin, kestrel, osprey, harrier."""
    names = [*NAMES, *(f"extra-{number}" for number in range(vehicles))][:vehicles]
    content = {
        "format": 1,
        "name": "meadow",
        "title": "A meadow",
        "datum": {"latitude_deg": 47.0, "longitude_deg": 8.0},
        "area": {"cell_m": 10.0, "rectangle_enu_m": [0.0, 0.0, 200.0, 200.0]},
        "terrain": {"kind": "flat", "elevation_amsl_m": 0.0},
        "task": {"kind": "explore"},
        "vehicles": [
            {
                "name": name,
                "start_enu_m": [20.0 + 25.0 * (number % 6), 20.0 + 25.0 * (number // 6)],
                "speed_m_s": 10.0,
                "sensor": {"kind": "range", "range_m": 100.0},
                "min_above_terrain_m": 20.0,
                "max_above_terrain_m": 60.0,
            }
            for number, name in enumerate(names)
        ],
    }
    return plan_mission(msgspec.convert(content, Mission))


class Voice:
    """One vehicle's voice: numbers its messages as an agent does."""

    def __init__(self, name: str, boot_id: int = 1, stream_id: int = 7) -> None:
        self.name = name
        self.boot_id = boot_id
        self.stream_id = stream_id
        self.sequence = 0
        self.records = 0

    def _head(self, elapsed_s: float) -> dict[str, Any]:
        self.sequence += 1
        return {
            "sender": self.name,
            "boot_id": self.boot_id,
            "sequence": self.sequence - 1,
            "stamp_ms": EPOCH_MS + round(1_000 * elapsed_s),
        }

    def status(self, elapsed_s: float = 0.0, stage: Stage = Stage.WORKING, **changes: Any) -> Status:
        fields: dict[str, Any] = {
            "stage": stage,
            "mode": "guided",
            "armed": True,
            "position_cm": (5_000, 5_000, 3_000),
            "velocity_cm_s": (0, 0, 0),
            "heading_deg": 90,
            "battery_permille": 870,
            "leg_end_cm": (9_000, 5_000, 3_000),
            "home_cm": (2_000, 2_000, 0),
            "known_permille": 0,
            "first_seen_cells": 0,
            "bytes_sent": 0,
            "messages_dropped": 0,
            "why": "frontier 40 m E, claimed by nobody nearer",
        }
        return Status(**self._head(elapsed_s), **(fields | changes))

    def record(
        self, cells: Sequence[int], elapsed_s: float = 0.0, elevation_dm: int = 4_000, number: int | None = None
    ) -> DeltaRecord:
        number = self.records if number is None else number
        self.records = max(self.records, number + 1)
        indices = np.array(sorted(cells), dtype=np.int64)
        observations = CellObservations(
            indices,
            np.full(len(indices), elevation_dm, dtype=np.int32),
            np.full(len(indices), EPOCH_MS + round(1_000 * elapsed_s), dtype=np.int64),
        )
        return DeltaRecord(self.name, self.stream_id, number, pack_cells(observations))

    def delta(self, cells: Sequence[int], elapsed_s: float = 0.0, elevation_dm: int = 4_000) -> MapDelta:
        return MapDelta(**self._head(elapsed_s), record=self.record(cells, elapsed_s, elevation_dm))

    def repair(self, *records: DeltaRecord, elapsed_s: float = 0.0) -> Repair:
        return Repair(**self._head(elapsed_s), records=records)

    def digest(self, *streams: tuple[str, int, int]) -> Digest:
        return Digest(**self._head(0.0), streams=tuple(StreamHeld(*stream) for stream in streams))

    def claim(self, active: bool = True, goal_cm: tuple[int, int, int] = (15_000, 15_000, 3_000)) -> Claim:
        return Claim(**self._head(0.0), active=active, goal_cm=goal_cm, cost_m=10)

    def event(
        self, text: str, elapsed_s: float = 0.0, severity: Severity = Severity.NOTICE, code: str = "note"
    ) -> Event:
        return Event(**self._head(elapsed_s), severity=severity, code=code, text=text)

    def answer(self, command: Command, outcome: Outcome = Outcome.ACCEPTED, text: str = "") -> CommandResult:
        return CommandResult(
            **self._head(0.0),
            station=command.sender,
            station_boot_id=command.boot_id,
            command_id=command.command_id,
            verb=command.verb,
            outcome=outcome,
            text=text,
        )


class ListCounts:
    """A link's counters."""

    undecodable = 0
    overflowed = 0


class ListLink:
    """A link whose arrivals are put in by a test and whose publications stay in a list."""

    def __init__(self) -> None:
        self.arriving: list[AnyMessage] = []
        self.alive_changes: list[tuple[str, bool]] = []
        self.published: list[AnyMessage] = []
        self.counters = ListCounts()
        self.closed = False

    def poll(self) -> list[AnyMessage]:
        taken, self.arriving = self.arriving, []
        return taken

    def poll_alive(self) -> list[tuple[str, bool]]:
        taken, self.alive_changes = self.alive_changes, []
        return taken

    def publish(self, message: AnyMessage) -> None:
        self.published.append(message)

    def close(self) -> None:
        self.closed = True

    def commands(self) -> list[Command]:
        return [message for message in self.published if isinstance(message, Command)]

    def digests(self) -> list[Digest]:
        return [message for message in self.published if isinstance(message, Digest)]
