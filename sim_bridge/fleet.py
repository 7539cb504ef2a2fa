"""All simulated vehicles of a mission on one clock: what the server serves and the lock-step runner steps."""

from __future__ import annotations

import math

import numpy as np

from sim_bridge.battery import Battery
from sim_bridge.clock import SimClock
from sim_bridge.dynamics import Bodies
from sim_bridge.parameter_sets.copter import copter_rows
from sim_bridge.parameters import ParameterTable
from sim_bridge.referee import Referee
from sim_bridge.vehicle import Copter
from sim_bridge.world import World
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.mission.load import MissionPlan

STEP_US = 50_000
"""Longest physical step, microseconds."""


class Fleet:
    """The vehicles of a mission in their world.

    Attributes
    ----------
    clock
        The one clock of all vehicles.
    vehicles
        By team index; each takes orders and tells its state, see `Copter`.
    referee
        What the truth says about separation and the fence.

    Example
    -------
    ::

        fleet = Fleet(plan, World.of(plan))
        fleet.vehicles[0].arm()
        fleet.step(0.5)
        fleet.vehicles[0].snapshot.position_enu_m
    """

    def __init__(self, plan: MissionPlan, world: World) -> None:
        mission = plan.mission
        self.plan = plan
        self.world = world
        self.clock = SimClock()
        self.bodies = Bodies(world, np.array([v.start_enu_m[:2] for v in mission.vehicles], dtype=np.float64))
        self.vehicles = tuple(
            Copter(
                index,
                self.bodies,
                self.clock,
                ParameterTable(copter_rows(), {"SYSID_THISMAV": plan.system_id(index)}),
                Battery(mission.simulation.endurance_s),
                mission.simulation.ready_after_s,
            )
            for index in range(len(mission.vehicles))
        )
        self.referee = Referee(plan.fence_en_m)

    @property
    def time_s(self) -> float:
        """Simulated seconds since the start."""
        return self.clock.time_s

    def step(self, dt_s: float) -> None:
        """Let `dt_s` simulated seconds pass, in equal physical steps of at most 0.05 s."""
        span_us = round(dt_s * 1e6)
        steps = max(1, math.ceil(span_us / STEP_US))
        done_us = 0
        for number in range(1, steps + 1):
            upto_us = span_us * number // steps
            self._step(upto_us - done_us)
            done_us = upto_us

    def _step(self, step_us: int) -> None:
        dt_s = step_us * 1e-6
        self.clock.elapsed_us += step_us
        self.bodies.advance(dt_s)
        for vehicle in self.vehicles:
            vehicle.update(dt_s)
        airborne = np.array([not vehicle.landed for vehicle in self.vehicles])
        self.referee.observe(self.bodies.position_enu_m, airborne, dt_s)

    def scan(self, index: int) -> CellObservations:
        """What vehicle `index`'s sensor sees of the true surface now."""
        return self.world.scan(
            self.vehicles[index].pilot.position_enu_m,
            self.plan.mission.vehicles[index].sensor.range_m,
            self.clock.unix_ms,
        )

    @property
    def crashes(self) -> int:
        """How many vehicles have hit the ground too fast."""
        return sum(vehicle.crashed for vehicle in self.vehicles)

    def distance_from_home_m(self, index: int) -> float:
        """Distance over ground from where the vehicle would return to; 0 before it knows."""
        home = self.vehicles[index].home_enu_m
        if home is None:
            return 0.0
        east_m, north_m, _ = self.vehicles[index].pilot.position_enu_m
        return math.hypot(east_m - home[0], north_m - home[1])
