"""All simulated vehicles of a mission on one clock: what the server serves and the lock-step runner steps."""

from __future__ import annotations

import math

import numpy as np

from sim_bridge.beam import Beam
from sim_bridge.clock import SimClock
from sim_bridge.dynamics import Bodies
from sim_bridge.environment import Environment
from sim_bridge.faults import FaultBoard
from sim_bridge.navigation import Navigation
from sim_bridge.referee import Referee
from sim_bridge.vehicles.build import body_kind, new_vehicle
from sim_bridge.world import World
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.domain.range_image import RangeImage
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.vehicles import HalfSphereSensor, SingleBeamSensor

STEP_US = 50_000
"""Longest physical step, microseconds."""
WEATHER_KEY, NAVIGATION_KEY, BEAM_KEY = 1100, 1200, 1300
"""First part of the keys of the random streams, apart from the vehicles' own, which are their indices."""


class Fleet:
    """The vehicles of a mission in their world.

    Attributes
    ----------
    clock
        The one clock of all vehicles.
    vehicles
        By team index; each takes orders and tells its state, see `Vehicle`.
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
        starts_en_m = np.array([v.start_enu_m[:2] for v in mission.vehicles], dtype=np.float64)
        kinds = np.array([body_kind(table) for table in mission.vehicles], dtype=np.int64)
        self.bodies = Bodies(world, starts_en_m, kinds, mission.simulation.water_level_m)
        count = len(mission.vehicles)
        self._environment = Environment(
            mission.simulation, self.bodies, [_stream(mission.seed, WEATHER_KEY, index) for index in range(count)]
        )
        self.navigation = Navigation(
            self.bodies,
            mission.simulation.gps_noise_m,
            [_stream(mission.seed, NAVIGATION_KEY, index) for index in range(count)],
        )
        self.vehicles = tuple(new_vehicle(plan, index, self.bodies, self.clock) for index in range(count))
        self._beams: list[Beam] = []
        for index, table in enumerate(mission.vehicles):
            if isinstance(table.sensor, SingleBeamSensor):
                beam = Beam(table.sensor, self.bodies, index, _stream(mission.seed, BEAM_KEY, index))
                self.vehicles[index].beam = beam
                self._beams.append(beam)
        self.faults = FaultBoard(plan, self.vehicles, self.navigation)
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
        self._environment.advance(dt_s)
        self.bodies.advance(dt_s)
        self.navigation.advance(dt_s)
        for beam in self._beams:
            beam.advance(self.clock.time_s)
        self.faults.tick(self.clock.time_s)
        for vehicle in self.vehicles:
            vehicle.update(dt_s)
        airborne = np.array([not vehicle.landed for vehicle in self.vehicles])
        if self.world.town is not None:
            for index in np.flatnonzero(airborne & self.world.town.touched_by(self.bodies.position_enu_m)):
                self.vehicles[index].hit_building()
        self.referee.observe(self.bodies.position_enu_m, airborne, dt_s)

    def scan(self, index: int) -> CellObservations | RangeImage:
        """What vehicle `index`'s sensor sees of the true surface now."""
        sensor, stamp_ms = self.plan.mission.vehicles[index].sensor, self.clock.unix_ms
        position_enu_m = self.vehicles[index].true_position_enu_m
        if self.world.town is not None and isinstance(sensor, HalfSphereSensor):
            return self.world.town.scan(position_enu_m, sensor.range_m, stamp_ms)
        return self.world.scan(position_enu_m, sensor.range_m, stamp_ms)

    @property
    def crashes(self) -> int:
        """How many vehicles have hit the ground too fast."""
        return sum(vehicle.crashed for vehicle in self.vehicles)

    def distance_from_home_m(self, index: int) -> float:
        """Distance over ground from where the vehicle would return to; 0 before it knows."""
        home = self.vehicles[index].home_enu_m
        if home is None:
            return 0.0
        east_m, north_m, _ = self.vehicles[index].true_position_enu_m
        return math.hypot(east_m - home[0], north_m - home[1])


def _stream(seed: int, key: int, index: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(key, index)))
