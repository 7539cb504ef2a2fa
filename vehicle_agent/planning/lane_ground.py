"""The ground that lanes are planned for, in blocks: what is unseen, how high it may be, where looks were in vain."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.lane_sight import Sight, look_around, sight_of
from vehicle_agent.domain.lane_window import Window, window_around
from vehicle_agent.planning.ground_spline import GroundSpline
from vehicle_agent.planning.interface import Situation
from vehicle_agent.planning.patches import PatchDivision, UnseenPatches


@dataclass(frozen=True, slots=True)
class LaneGroundParams:
    """How the ground is looked at.

    Attributes
    ----------
    block
        Width of the blocks of ground that are counted, in sensing ranges.
    widest_block
        Of wide ground the blocks are wider; wider than so many sensing ranges they are none for lanes.
    window
        A plan is for so many squared sensing ranges of unseen ground for each vehicle, those nearest to the team.
    most_looked
        Share of the surest look that a fruitless look counts for at most: right above, all is tried again.
    """

    block: float = 0.25
    widest_block: float = 0.5
    window: float = 40.0
    most_looked: float = 0.9


MOST_BLOCKS = 1_000_000
"""Of wider ground the blocks are wider."""
LOOKS_PER_MEND = 3
"""Places on the way since the last plan from where a vehicle is taken to have looked around."""


@dataclass(frozen=True, slots=True)
class Outlook:
    """What a plan is made for.

    Attributes
    ----------
    window
        The blocks.
    sight
        Chances of seeing, for these blocks.
    whole_blocks
        How many blocks all that was ever to be seen by such a plan would fill.
    """

    window: Window
    sight: Sight
    whole_blocks: float


class LaneGround:
    """One vehicle's view of the ground.

    Parameters
    ----------
    situation
        The first one: its map's grid is divided into blocks.

    Attributes
    ----------
    range_blocks : the sensing range, in blocks.
    """

    def __init__(self, situation: Situation, params: LaneGroundParams) -> None:
        self._params, self._range_m = params, situation.range_m
        grid = situation.team_map.grid
        self._division = PatchDivision(grid, params.block * situation.range_m, MOST_BLOCKS)
        self._unseen = UnseenPatches(self._division)
        self._block_m = np.array(self._division.size_cells) * grid.cell_m
        self.range_blocks = situation.range_m / float(self._block_m.mean())
        above = situation.constraints.min_above_m / float(self._block_m.mean())
        self._sight = sight_of(self.range_blocks, above, self._division.shape)
        self._spline = GroundSpline(self.range_blocks)
        self._middle_cells = self._division.middle_cells()
        self._looked_from: dict[int, FloatArray] = {}

    @property
    def is_too_wide(self) -> bool:
        """Whether its blocks are too wide for lanes."""
        return self._params.widest_block * self.range_blocks < 1.0

    def unseen_ranges2(self, situation: Situation) -> float:
        """How much is unseen, in squared sensing ranges."""
        self._unseen.follow(situation.team_map, situation.area_cells)
        return self._unseen.in_all() * self._division.grid.cell_m**2 / self._range_m**2

    def to_blocks(self, places_en_m: FloatArray) -> FloatArray:
        """Places in blocks, block centres at whole numbers: (N, 2) ENU metres -> (N, 2)."""
        blocks: FloatArray = (places_en_m - self._division.corner_en_m) / self._block_m - 0.5
        return blocks

    def inside(self, places: FloatArray) -> FloatArray:
        """Places in blocks, those beside the ground led to its edge: (N, 2) -> (N, 2)."""
        moved: FloatArray = np.clip(places, 0.0, np.array(self._division.shape) - 1.0)
        return moved

    def to_metres(self, places: FloatArray) -> FloatArray:
        """Places in blocks: (N, 2) -> (N, 2) ENU metres."""
        places_en_m: FloatArray = (places + 0.5) * self._block_m + self._division.corner_en_m
        return places_en_m

    def look_out(self, situation: Situation, vehicles: dict[int, FloatArray], bends: FloatArray) -> Outlook:
        """What a plan is to be made for now, with what vehicles have just seen in vain.

        Parameters
        ----------
        vehicles : where each is, in blocks, by its index in the team.
        bends : (N, 2) float64, blocks, what vehicles reached of their ways lately. A bend counts as reached a little
            before it is; if what was to be seen from it alone still counted as seen from there, it would be flown to
            for ever.
        """
        self._unseen.follow(situation.team_map, situation.area_cells)
        cells_each = math.prod(self._division.size_cells)
        places = np.array(list(vehicles.values()))
        most = self._params.window * self.range_blocks**2 * len(places)
        window = window_around(self._unseen.by_place() / cells_each, places, most)
        box = window.columns, window.rows
        columns, rows = (middle[part] for middle, part in zip(self._middle_cells, box, strict=True))
        ground = self._spline.expect(situation.team_map.elevation_where(columns, rows) / float(self._block_m.mean()))
        whole = self._sight
        sight = whole.over(ground, np.ascontiguousarray(whole.looked[box]))
        looks = np.concatenate([self._looks(vehicles), bends]) - window.corner
        look_around(sight, looks, int(self._params.most_looked * whole.odds.max()))
        whole.looked[box] = sight.looked
        whole_blocks = np.count_nonzero(situation.area_cells) / cells_each
        return Outlook(window, sight, whole_blocks if window.is_all else most)

    def _looks(self, vehicles: dict[int, FloatArray]) -> FloatArray:
        """From where vehicles looked around on their ways to where they are: (N, 2) blocks."""
        shares = np.linspace(0.0, 1.0, LOOKS_PER_MEND, endpoint=False)[:, None]
        ways = [(place, self._looked_from.get(index, place)) for index, place in vehicles.items()]
        self._looked_from = dict(vehicles)
        return np.concatenate([place + shares * (before - place) for place, before in ways])
