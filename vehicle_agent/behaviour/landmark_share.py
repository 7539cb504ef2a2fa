"""The team's landmarks as they are shared: soundings folded in, told in small packets, mended by checksums."""

from __future__ import annotations

from collections import Counter

import numpy as np

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.landmark_atlas import LandmarkAtlas
from vehicle_agent.domain.landmark_records import LandmarkRecords
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.sounding import TYPICAL_SLOPE, beam_of, landmark_params
from vehicle_agent.ports import SensorScan
from vehicle_agent.wire.landmark_blob import pack_landmarks, unpack_landmarks

BYTES_PER_RECORD = 14
"""At least as long as any packed record."""


class LandmarkShare:
    """A `SharedMap` of landmarks.

    Attributes
    ----------
    refused
        Records of teammates that were dropped, by reason.
    """

    def __init__(self, plan: MissionPlan, index: int) -> None:
        self.team_map = LandmarkAtlas(plan.grid, landmark_params(plan), len(plan.mission.vehicles), index)
        self.version = 0
        self.refused: Counter[str] = Counter()
        self._sensor = beam_of(plan, index)
        self._unsaid = np.zeros(plan.grid.cells, dtype=np.bool_)

    def sound(self, position_enu_m: Point, range_m: float, unfixed_s: float) -> None:
        """Fold one reading straight down in; one beside the area concerns no landmark."""
        grid, landmarks = self.team_map.grid, self.team_map.landmarks
        if not grid.contains(*position_enu_m[:2]):
            return
        here = np.array([np.ravel_multi_index(grid.cell_of(*position_enu_m[:2]), grid.shape)], dtype=np.int64)
        aside_m = float(np.hypot(*(landmarks.layout.positions_en_m[here[0]] - position_enu_m[:2])))
        deviation = np.hypot(self._sensor.noise_sd_m(np.array([range_m]), unfixed_s), TYPICAL_SLOPE * aside_m)
        landmarks.observe(here, np.array([position_enu_m[2] - range_m]), deviation)
        self._unsaid[here] = True
        self.version += 1

    def take_records(self, records: LandmarkRecords) -> None:
        """Fold in what a teammate told."""
        result = self.team_map.landmarks.merge(records)
        self.refused += result.dropped
        self.version += bool(len(result.changed))

    def take_scan(self, scan: SensorScan) -> tuple[int, bool]:
        """Landmarks are measured by the autopilot's beam; a scan of a payload is none of ours."""
        return 0, False

    def next_blob(self, most_bytes: int) -> bytes | None:
        fresh = np.flatnonzero(self._unsaid)[: max(1, most_bytes // BYTES_PER_RECORD)]
        if len(fresh) == 0:
            return None
        self._unsaid[fresh] = False
        return pack_landmarks(self.team_map.landmarks.own_records(fresh))

    def fold(self, contributor: int, blob: bytes) -> bool:
        records = unpack_landmarks(blob)
        if records is None or bool((records.contributors != contributor).any()):
            return False
        self.take_records(records)
        return True

    def known_fraction(self, area_cells: BoolArray) -> float:
        """Share of landmarks that need no more measurements: accurate, or given up."""
        landmarks = self.team_map.landmarks
        done = ~landmarks.open
        return float(done[area_cells.ravel()].mean()) if area_cells.any() else 1.0

    def first_seen(self, index: int, area_cells: BoolArray) -> float:
        return self.team_map.first_observer_share(index, area_cells)

    def highest_up_m(self) -> float:
        known = self.team_map.observed
        return float(np.max(self.team_map.elevation_m, where=known, initial=-1e6))
