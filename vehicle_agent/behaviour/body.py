"""What differs between kinds of vehicles on a trip: how it is set up, begins, counts as under way, and ends."""

from __future__ import annotations

from typing import Protocol

from vehicle_agent.behaviour.preflight import (
    parameters_before_arming,
    submarine_parameters_before_arming,
    take_off_height_m,
)
from vehicle_agent.domain.frames import Point
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.ports import Disarm, GoTo, Land, Landed, Order, SetParameter, TakeOff, VehicleState

LEFT_GROUND_M = 1.0
UNDER_WAY_SHARE = 0.95
"""Share of the depth from which on a dive counts as done."""
SURFACED_M = 0.4
"""So near to the water's surface a submarine may stop its motors."""


class Body(Protocol):
    """One kind of vehicle, as its flight sees it.

    Attributes
    ----------
    keeps_return_height
        Whether its autopilot returns by itself at a height that must be kept above all known ground.
    """

    keeps_return_height: bool

    def parameters(self) -> tuple[SetParameter, ...]:
        """What its autopilot must be set to before it is armed."""
        ...

    def set_out(self, home_enu_m: Point) -> Order:
        """What it is told once armed."""
        ...

    def set_out_height_m(self) -> float:
        """Above home, where setting out ends; negative below."""
        ...

    def has_set_out(self, state: VehicleState, home_enu_m: Point) -> bool:
        """Whether it has left the place where it was armed."""
        ...

    def is_under_way(self, state: VehicleState, home_enu_m: Point) -> bool:
        """Whether it has come where its work begins."""
        ...

    def rests(self, state: VehicleState) -> bool:
        """Whether its autopilot says that it has not set out, or is down again."""
        ...

    def word(self, away_m: float) -> tuple[str, str]:
        """Code and words of having set out, so many metres above home."""
        ...

    def is_unsure(self, state: VehicleState) -> bool:
        """Whether its autopilot has yet to tell where it is between the ground and its work."""
        ...

    def end_order(self, state: VehicleState, begun: bool) -> Order | None:
        """What to ask for where its trip ends, `begun` once its autopilot has been seen ending it."""
        ...


class CopterBody:
    """Takes off, and lands and disarms by itself."""

    keeps_return_height = True

    def __init__(self, plan: MissionPlan, index: int) -> None:
        self._plan, self._index = plan, index
        voxels = plan.voxel_grid
        self._slack_m = 0.05 * self.set_out_height_m() if voxels is None else 0.4 * voxels.voxel_m

    def parameters(self) -> tuple[SetParameter, ...]:
        return parameters_before_arming(self._plan, self._index)

    def set_out(self, home_enu_m: Point) -> Order:
        return TakeOff(self.set_out_height_m())

    def set_out_height_m(self) -> float:
        return take_off_height_m(self._plan, self._index)

    def has_set_out(self, state: VehicleState, home_enu_m: Point) -> bool:
        return state.position_enu_m[2] - home_enu_m[2] > LEFT_GROUND_M

    def is_under_way(self, state: VehicleState, home_enu_m: Point) -> bool:
        return state.position_enu_m[2] - home_enu_m[2] >= self.set_out_height_m() - self._slack_m

    def rests(self, state: VehicleState) -> bool:
        return state.landed is Landed.ON_GROUND

    def word(self, away_m: float) -> tuple[str, str]:
        return "took-off", f"airborne at {away_m:.0f} m above home"

    def is_unsure(self, state: VehicleState) -> bool:
        return state.landed is Landed.UNKNOWN

    def end_order(self, state: VehicleState, begun: bool) -> Order | None:
        return None if begun else Land()


class SubmarineBody:
    """Dives to its depth, and comes up to end its trip; ArduSub tells no landed state and does not disarm by itself."""

    keeps_return_height = False

    def __init__(self, plan: MissionPlan, index: int) -> None:
        self._plan, self._index = plan, index
        self._depth_m = plan.mission.vehicles[index].depth_m or 0.0
        self._surface_up_m = plan.mission.simulation.water_level_m

    def parameters(self) -> tuple[SetParameter, ...]:
        return submarine_parameters_before_arming(self._plan, self._index)

    def set_out(self, home_enu_m: Point) -> Order:
        return GoTo((home_enu_m[0], home_enu_m[1], self._surface_up_m - self._depth_m))

    def set_out_height_m(self) -> float:
        return -self._depth_m

    def has_set_out(self, state: VehicleState, home_enu_m: Point) -> bool:
        return self._surface_up_m - state.position_enu_m[2] > LEFT_GROUND_M

    def is_under_way(self, state: VehicleState, home_enu_m: Point) -> bool:
        return self._surface_up_m - state.position_enu_m[2] >= UNDER_WAY_SHARE * self._depth_m

    def rests(self, state: VehicleState) -> bool:
        """Near the surface: an armed one may not have dived yet."""
        return self._surface_up_m - state.position_enu_m[2] <= SURFACED_M

    def word(self, away_m: float) -> tuple[str, str]:
        return "dived", f"under way {-away_m:.1f} m below the surface"

    def is_unsure(self, state: VehicleState) -> bool:
        return False

    def end_order(self, state: VehicleState, begun: bool) -> Order | None:
        if self.rests(state):
            return Disarm()
        return None if begun else Land()


def body_of(plan: MissionPlan, index: int) -> Body:
    """The body of a vehicle of the mission."""
    if plan.mission.vehicles[index].type == "underwater-vehicle":
        return SubmarineBody(plan, index)
    return CopterBody(plan, index)
