"""Keeps the height of the autopilot's own return above all ground that is known by now."""

from __future__ import annotations

from vehicle_agent.behaviour.preflight import return_height_m
from vehicle_agent.behaviour.rhythm import Rhythm
from vehicle_agent.behaviour.shared_map import SharedMap
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.ports import ActionResult

PERIOD_S = 3.0
SAME_M = 0.5


class ReturnHeight:
    """One vehicle's return height.

    Attributes
    ----------
    height_m
        Above home, as the autopilot has accepted it.
    """

    def __init__(self, plan: MissionPlan, index: int) -> None:
        self._plan, self._index = plan, index
        self._rhythm = Rhythm(PERIOD_S)
        self._asked: tuple[int, float] | None = None
        self.height_m = return_height_m(plan, index, 0.0, 0.0)

    def due_m(self, now_s: float, shared: SharedMap, home_up_m: float) -> float | None:
        """The height to ask the autopilot for now; None when the present one does or it is not time to ask."""
        if not self._rhythm.is_due(now_s):
            return None
        wanted_m = return_height_m(self._plan, self._index, shared.highest_up_m(), home_up_m)
        return wanted_m if abs(wanted_m - self.height_m) > SAME_M else None

    def asked(self, action_id: int, height_m: float) -> None:
        self._asked = (action_id, height_m)

    def hear(self, result: ActionResult) -> None:
        """Take a result; those of other actions are ignored, a refusal is followed by another try."""
        if self._asked is not None and result.action_id == self._asked[0]:
            if result.accepted:
                self.height_m = self._asked[1]
            self._asked = None
