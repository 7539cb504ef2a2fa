"""How well a sea floor is known: the landmarks of a map mission as vehicles tell them, in immutable versions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ground_station.drawn_surface import DrawnSurface, redrawn
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.landmark_atlas import LandmarkAtlas
from vehicle_agent.domain.landmark_layout import LandmarkParams
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.tasks import MapTask
from vehicle_agent.wire.landmark_blob import unpack_landmarks

BELIEVED_M = 12_000.0
"""Heights beyond the deepest sea are no heights."""
BEST_SHARE = 1 / 16
"""Of the accurate standard deviation: no single sounding is taken to be better."""
SHOWN_ACCURATE_SDS = 4.0
"""Uncertainty is shown from none to so many times what the mission calls accurate."""


@dataclass(frozen=True, slots=True)
class LandmarkPicture:
    """One version of what is known; the atlas is not changed any more.

    Attributes
    ----------
    atlas
        The landmarks, one per cell.
    drawn
        The surface drawn through them, of this version or one not much older; None before there is enough to draw.
    """

    atlas: LandmarkAtlas
    drawn: DrawnSurface | None = None

    @classmethod
    def of(cls, plan: MissionPlan) -> LandmarkPicture | None:
        """Nothing known yet; None for missions that map no landmarks."""
        task = plan.mission.task
        if not isinstance(task, MapTask):
            return None
        params = LandmarkParams(
            task.accurate_sd_m, BEST_SHARE * task.accurate_sd_m, -BELIEVED_M, BELIEVED_M, task.attempts
        )
        return cls(LandmarkAtlas(plan.grid, params, len(plan.mission.vehicles), 0))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, LandmarkPicture) and self.atlas.landmarks == other.atlas.landmarks

    __hash__ = None  # type: ignore[assignment]

    @property
    def sd_m(self) -> FloatArray:
        """(columns, rows) float64, standard deviation of every cell's height; infinite where unknown."""
        return self.atlas.sd_m

    @property
    def most_shown_sd_m(self) -> float:
        """The far end of the colours."""
        return SHOWN_ACCURATE_SDS * self.atlas.landmarks.params.accurate_sd_m

    @property
    def accurate_share(self) -> float:
        """Share of all landmarks that are accurately estimated, in [0, 1]."""
        return float(np.mean(self.atlas.accurate))

    def joined_with(
        self, told: Iterable[tuple[int, int, bytes]]
    ) -> tuple[LandmarkPicture, list[tuple[int, CellObservations]], int]:
        """The next version with (team index, Unix milliseconds, packed records) folded in.

        Returns
        -------
        picture : itself when nothing is news.
        observations : (team index, cells) pairs of landmarks that nobody had measured before.
        malformed : how many blobs could not be read.
        """
        atlas, seen, malformed, changed = self.atlas.copy(), list[tuple[int, CellObservations]](), 0, False
        for index, stamp_ms, blob in told:
            records = unpack_landmarks(blob)
            if records is None:
                malformed += 1
                continue
            known = atlas.observed.ravel()
            news = atlas.landmarks.merge(records).changed
            changed = changed or len(news) > 0
            fresh = news[~known[news] & atlas.observed.ravel()[news]]
            if len(fresh):
                heights_dm = np.rint(10 * atlas.elevation_m.ravel()[fresh]).astype(np.int32)
                stamps_ms = np.full(len(fresh), stamp_ms, dtype=np.int64)
                seen.append((index, CellObservations(fresh, heights_dm, stamps_ms)))
        picture = LandmarkPicture(atlas, redrawn(self.drawn, atlas)) if changed else self
        return picture, seen, malformed
