"""A whole fleet in one process on simulated time: the very agents that fly, without sockets, the same every time.

One tick: bodies move, agents are told what their autopilots, sensors and radios bring, agents decide, their orders
and messages go out. Messages pass through the wire codec, so that bytes are counted as they would be sent.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from missions.covered import covered_fraction, covers
from missions.depth_map import DepthMap, draw_depth_map, maps, write_depth_map
from missions.lockstep_ranging import AcousticRanges
from missions.lockstep_vehicle import LockstepVehicle
from missions.yardstick import merged, observable, share_seen, unseen_words
from sim_bridge.fleet import Fleet
from sim_bridge.radio import Radio, RadioParams
from sim_bridge.world import World
from vehicle_agent.crew import make_agent
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.landmark_atlas import LandmarkAtlas
from vehicle_agent.domain.team_map import TeamMap
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.codec import Codec
from vehicle_agent.wire.keys import key, topic_of
from vehicle_agent.wire.messages import Event, Stage

TICK_S = 0.2
RECORD_PERIOD_S = 1.0
RADIO_KEY, RANGES_KEY = 2_000, 2_200
GRACE_S = 1_200.0
"""Time after the mission's limit for the way home, before a run is called off."""


@dataclass(slots=True)
class LockstepResult:
    """What a simulated mission left behind.

    Attributes
    ----------
    plan
        The mission.
    team_map
        All agents' maps merged.
    true_elevation_m
        (columns, rows) float64, the world's surface, ENU z.
    reachable
        Bool, what of the surface can be seen at all: cells, (columns, rows), or in a town voxels.
    times_s : (T,) float64, simulated seconds.
    positions_enu_m : (T, N, 3) float64.
    observed_fraction_curve : (T,) float64, share of the reachable cells seen by the team.
    elapsed_s
        Simulated seconds until everybody was down.
    bytes_sent, messages_dropped
        Per vehicle.
    finished, crashed
        Per vehicle: landed and disarmed after its mission; hit the ground.
    min_separation_m, fence_breaches
        By the referee.
    worked_at_enu_m
        Where each vehicle was last at work, by name.
    events
        What the agents told, as (simulated seconds, vehicle, code, text).
    depth_map
        What a mission that maps has drawn; None for others.
    true_solid
        (columns, rows, layers) bool, what is solid of a town; None in the open country.
    """

    plan: MissionPlan
    team_map: TeamMap
    true_elevation_m: FloatArray
    reachable: np.ndarray[Any, np.dtype[np.bool_]]
    times_s: FloatArray
    positions_enu_m: FloatArray
    observed_fraction_curve: FloatArray
    elapsed_s: float
    bytes_sent: list[int]
    messages_dropped: list[int]
    finished: list[bool]
    crashed: list[bool]
    min_separation_m: float
    fence_breaches: int
    worked_at_enu_m: dict[str, Point] = field(default_factory=dict)
    events: list[tuple[float, str, str, str]] = field(default_factory=list)
    depth_map: DepthMap | None = None
    true_solid: np.ndarray[Any, np.dtype[np.bool_]] | None = None

    @property
    def covered_fraction(self) -> float:
        """Share of the area in sight from where the vehicles were last at work."""
        surface = self.true_elevation_m if self.true_solid is None else self.true_solid
        return covered_fraction(self.plan, surface, self.worked_at_enu_m)

    @property
    def observed_fraction(self) -> float:
        """Share of the reachable surface that the team has seen."""
        return share_seen(self.team_map.observed, self.reachable)

    @property
    def not_seen(self) -> str:
        """What of the area was not observed, in words; empty when all of it was."""
        return "" if maps(self.plan) else unseen_words(self.plan, self.team_map.observed, self.reachable)

    def summary(self) -> dict[str, Any]:
        """Figures of the run, as saved in `summary.json`."""
        names = self.plan.vehicle_names
        drawn = self.depth_map
        moved = np.linalg.norm(np.diff(self.positions_enu_m, axis=0), axis=2).sum(axis=0)
        return {
            "mission": self.plan.mission.name,
            "seed": self.plan.mission.seed,
            "planner": self.plan.mission.task.planner,
            "observed_fraction": self.observed_fraction,
            "not_seen": self.not_seen,
            "covered_fraction": self.covered_fraction if covers(self.plan) else None,
            "map_error_m": None if drawn is None else drawn.rms_error_m,
            "elapsed_s": round(self.elapsed_s, 1),
            "min_separation_m": self.min_separation_m if math.isfinite(self.min_separation_m) else None,
            "fence_breaches": self.fence_breaches,
            "vehicles": {
                name: {
                    "finished": self.finished[index],
                    "crashed": self.crashed[index],
                    "distance_m": round(float(moved[index]), 1),
                    "first_seen_cells": self.team_map.first_observer_share(index, self.plan.area_cells),
                    "bytes_sent": self.bytes_sent[index],
                    "bytes_per_s": round(self.bytes_sent[index] / max(self.elapsed_s, 1.0), 1),
                    "messages_dropped": self.messages_dropped[index],
                }
                for index, name in enumerate(names)
            },
        }

    def save(self, folder: Path) -> None:
        """Write `summary.json`, `events.jsonl` and `run.npz`; the same run gives the same bytes."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "summary.json").write_text(json.dumps(self.summary(), indent=1, sort_keys=True) + "\n")
        with (folder / "events.jsonl").open("w") as out:
            for time_s, vehicle, code, text in self.events:
                out.write(json.dumps({"time_s": time_s, "vehicle": vehicle, "code": code, "text": text}) + "\n")
        arrays = {
            "times_s": self.times_s,
            "positions_enu_m": self.positions_enu_m,
            "observed_fraction": self.observed_fraction_curve,
            **self.team_map.arrays(),
            "true_elevation_m": self.true_elevation_m,
        }
        np.savez(folder / "run.npz", **arrays)  # type: ignore[arg-type]
        if (drawn := self.depth_map) is not None:
            write_depth_map(self.plan, drawn, folder)


def simulate(
    plan: MissionPlan,
    world: World | None = None,
    progress: Callable[[float, float], None] | None = None,
    watch: Callable[[float, Sequence[TeamMap]], None] | None = None,
) -> LockstepResult:
    """Fly a mission in lock-step and return what it left behind.

    Parameters
    ----------
    plan
        The mission; its seed decides everything.
    world
        The true terrain; built from the plan when left out.
    progress
        Called about once per simulated second with the simulated seconds and the share of the reachable surface seen.
    watch
        Called as often with the simulated seconds and each vehicle's map.
    """
    world = world or World.of(plan)
    reachable = observable(plan, world)
    run = _Run(plan, world, reachable, progress, watch)
    limit_s = plan.mission.stop.time_limit_s + GRACE_S
    while not all(agent.finished for agent in run.agents) and run.fleet.time_s < limit_s:
        run.tick()
    agents, fleet, record = run.agents, run.fleet, run.record
    team_map = merged([agent.map for agent in agents])
    return LockstepResult(
        plan=plan,
        team_map=team_map,
        true_elevation_m=world.elevation_m,
        reachable=reachable,
        times_s=np.array(record.times_s),
        positions_enu_m=np.array(record.positions).reshape(-1, len(agents), 3),
        observed_fraction_curve=np.array(record.observed_fractions),
        elapsed_s=fleet.time_s,
        bytes_sent=[agent.bytes_sent for agent in agents],
        messages_dropped=[codec.dropped for codec in run.codecs],
        finished=[agent.finished for agent in agents],
        crashed=[vehicle.crashed for vehicle in fleet.vehicles],
        min_separation_m=fleet.referee.min_separation_m,
        fence_breaches=fleet.referee.fence_breaches,
        worked_at_enu_m=record.worked_at_enu_m,
        events=record.events,
        depth_map=draw_depth_map(plan, team_map, world.elevation_m) if isinstance(team_map, LandmarkAtlas) else None,
        true_solid=None if world.town is None else world.town.solid,
    )


class _Run:
    """The fleet, its agents and the air between them, a tick at a time."""

    def __init__(
        self,
        plan: MissionPlan,
        world: World,
        reachable: np.ndarray[Any, np.dtype[np.bool_]],
        progress: Callable[[float, float], None] | None,
        watch: Callable[[float, Sequence[TeamMap]], None] | None,
    ) -> None:
        mission, vehicles = plan.mission, range(len(plan.mission.vehicles))
        self._plan = plan
        self.fleet = Fleet(plan, world)
        self.agents = [make_agent(plan, index, boot_id=1 + index, rng=_rng(plan, index)) for index in vehicles]
        self.codecs = [Codec() for _ in vehicles]
        self.record = _Record(self.fleet, reachable, progress, watch)
        self._links = [LockstepVehicle(plan, index, self.fleet) for index in vehicles]
        params = RadioParams(
            mission.radio.range_m, mission.radio.loss, mission.radio.delay_s, mission.radio.rate_bytes_s
        )
        self._radio = Radio(len(vehicles), params, _rng(plan, RADIO_KEY))
        self._ranging = AcousticRanges(self.fleet, _rng(plan, RANGES_KEY))

    def tick(self) -> None:
        """Move all bodies, deliver what has arrived, let every agent step, and take note."""
        self.fleet.step(TICK_S)
        self._deliver()
        positions = [vehicle.pilot.position_enu_m for vehicle in self.fleet.vehicles]
        for index in range(len(self.agents)):
            self._step(index, positions)
        self.record.tick([agent.map for agent in self.agents])

    def _deliver(self) -> None:
        for receiver, data in self._radio.receive(self.fleet.time_s):
            message = self.codecs[receiver].decode(data)
            if message is not None:
                inbox = self._links[receiver].inbox
                inbox.messages.append(message)
                if (measured := self._ranging.heard(receiver, message)) is not None:
                    inbox.ranges.append(measured)

    def _step(self, index: int, positions: list[Point]) -> None:
        """Let one agent decide; its orders and messages go out at once."""
        agent, link, codec, now_s = self.agents[index], self._links[index], self.codecs[index], self.fleet.time_s
        unix_s, inbox = link.take_inbox()
        agent.messages_dropped = codec.dropped
        outbox = agent.step(unix_s, inbox)
        if agent.stage is Stage.WORKING:
            self.record.worked_at_enu_m[agent.name] = positions[index]
        link.carry_out(outbox.actions)
        for message in outbox.messages:
            data = codec.encode(message)
            agent.bytes_sent += len(data) + len(key(self._plan.mission.name, agent.name, topic_of(message)))
            self._radio.send(index, data, now_s, positions)
            self._ranging.sent(index, message)
            if isinstance(message, Event):
                self.record.events.append((round(now_s, 3), agent.name, message.code, message.text))


def _rng(plan: MissionPlan, purpose: int) -> np.random.Generator:
    """A generator of its own for one purpose: an agent by its index, or one of the keys."""
    return np.random.default_rng(np.random.SeedSequence(plan.mission.seed, spawn_key=(purpose,)))


class _Record:
    """Samples the run once per simulated second."""

    def __init__(
        self,
        fleet: Fleet,
        reachable: np.ndarray[Any, np.dtype[np.bool_]],
        progress: Callable[[float, float], None] | None,
        watch: Callable[[float, Sequence[TeamMap]], None] | None,
    ) -> None:
        self._fleet, self._reachable = fleet, reachable
        self._progress, self._watch = progress, watch
        self._due_s = 0.0
        self.times_s: list[float] = []
        self.positions: list[list[tuple[float, float, float]]] = []
        self.observed_fractions: list[float] = []
        self.worked_at_enu_m: dict[str, Point] = {}
        self.events: list[tuple[float, str, str, str]] = []

    def tick(self, maps: list[TeamMap]) -> None:
        if self._fleet.time_s < self._due_s:
            return
        self._due_s = self._fleet.time_s + RECORD_PERIOD_S - 1e-6
        seen = np.logical_or.reduce([team_map.observed for team_map in maps])
        self.times_s.append(self._fleet.time_s)
        self.positions.append([vehicle.pilot.position_enu_m for vehicle in self._fleet.vehicles])
        self.observed_fractions.append(share_seen(seen, self._reachable))
        if self._progress is not None:
            self._progress(self._fleet.time_s, self.observed_fractions[-1])
        if self._watch is not None:
            self._watch(self._fleet.time_s, maps)
