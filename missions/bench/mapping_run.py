"""One team mapping one surface: moves, measures, exchanges, step by step (Kapoutsis 2015, sections 3.3 and 6)."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from missions.bench.mapping_kernels import all_linked, allowed
from missions.bench.mapping_radio import Exchange, message_of
from missions.bench.mapping_world import Setup, World
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.landmarks import LandmarkMap
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.range_sensing import heights_from_ranges
from vehicle_agent.planning.interface import Teammate
from vehicle_agent.planning.mapping.need_exchange import Packet
from vehicle_agent.wire.codec import Codec

FIRST_HEIGHT_M = 0.1
"""How far above the surface vehicles start."""
START_SPACING_M = 0.12


@dataclass(frozen=True, slots=True)
class Trouble:
    """What befalls a team.

    Attributes
    ----------
    loss
        Share of packets that do not arrive.
    dead_vehicle, dead_at
        Team index and step of a vehicle that stops for good; -1 for none.
    """

    loss: float = 0.0
    dead_vehicle: int = -1
    dead_at: int = 0


@dataclass(frozen=True, slots=True)
class MappingRun:
    """What a team did.

    Attributes
    ----------
    positions : (steps + 1, vehicles, 3) float64.
    remaining_percent : (steps + 1,), landmarks that nobody estimated accurately.
    sum_of_error : eq. 25.
    bytes_sent : of all vehicles together.
    step_ms : planning time of each decision.
    step_done_percent : accurate landmarks when it was taken.
    agree_after_repair : whether all living vehicles' maps are equal once they told each other all.
    """

    positions: FloatArray
    remaining_percent: FloatArray
    sum_of_error: float
    bytes_sent: int
    step_ms: list[float]
    step_done_percent: list[float]
    agree_after_repair: bool


class Team:
    """A team's bodies, sensors, maps and radio."""

    def __init__(
        self, world: World, setup: Setup, vehicles: int, exchange_of: Callable[[LandmarkMap], Exchange],
        trouble: Trouble, rng: np.random.Generator,
    ) -> None:  # fmt: skip
        self.world, self.setup, self.vehicles = world, setup, vehicles
        self._trouble, self._rng = trouble, rng
        self.maps = [LandmarkMap(world.layout, setup.landmark_params, vehicles, index) for index in range(vehicles)]
        self._exchanges = [exchange_of(known) for known in self.maps]
        self.positions = start_positions(world, vehicles)
        self.goals: list[Point | None] = [None] * vehicles
        self.present: BoolArray = np.ones(vehicles, dtype=np.bool_)
        self.accurate: BoolArray = np.zeros(len(world.layout), dtype=np.bool_)
        self.ever_seen: BoolArray = np.zeros(len(world.layout), dtype=np.bool_)
        self.heard: BoolArray = np.zeros((vehicles, vehicles), dtype=np.bool_)
        self.visible: list[IndexArray] = [np.empty(0, np.int64)] * vehicles
        self.sealed_by: IndexArray = np.zeros(vehicles, dtype=np.int64)
        self.sealed_now = 0
        self.bytes_sent = 0
        self.steps = 0
        self._codec = Codec()

    # Constraints

    def ends_allowed(self, index: int, ends: FloatArray) -> FloatArray:
        """Which ends of one vehicle's leg keep to area and height band, (M, 3) -> (M', 3); none for a dead one."""
        return ends[self._in_band(ends)] if self.present[index] else ends[:0]

    def teams_allowed(self, teams: FloatArray) -> BoolArray:
        """Which whole teams' ends keep the radio link, (M, vehicles, 3) -> (M,)."""
        return all_linked(teams, self.setup.radio_range_m, self._alone(), self.present)

    def move_allowed(self, index: int, ends: FloatArray) -> BoolArray:
        """Which legs of one vehicle alone are allowed while all others stay: (M, 3) -> (M,)."""
        ends = np.ascontiguousarray(ends)
        good = self._in_band(ends)
        good &= np.linalg.norm(ends - self.positions[index], axis=1) <= self.setup.reach_m * (1.0 + 1e-9)
        teams = np.repeat(self.positions[None], int(good.sum()), axis=0)
        teams[:, index] = ends[good]
        good[good] = self.teams_allowed(teams)
        return good

    def _in_band(self, ends: FloatArray) -> BoolArray:
        setup = self.setup
        return allowed(self.world.elevation, setup.clearance_m, setup.ceiling_m, np.ascontiguousarray(ends))

    def _alone(self) -> BoolArray:
        """Those that have nobody in radio range, through no fault of theirs."""
        alone: BoolArray = ~np.array([self.in_radio(index).any() for index in range(self.vehicles)])
        return alone

    def in_radio(self, index: int) -> BoolArray:
        """(vehicles,) whom a vehicle's packets reach."""
        away = np.linalg.norm(self.positions - self.positions[index], axis=1)
        heard: BoolArray = (away <= self.setup.radio_range_m) & self.present
        heard[index] = False
        return heard

    # A step

    def sense_and_tell(self) -> None:
        """Everybody measures where it is, then tells its packet."""
        self.steps += 1
        if self.steps == self._trouble.dead_at and self._trouble.dead_vehicle >= 0:
            self.present[self._trouble.dead_vehicle] = False
        before = int(self.accurate.sum())
        for index in np.flatnonzero(self.present).tolist():
            self._sense(index)
        self._tell()
        self.sealed_now = int(self.accurate.sum()) - before

    def _sense(self, index: int) -> None:
        known, sensor = self.maps[index], self.setup.sensor
        ids, true_ranges = self.world.visible(self.positions[index], sensor.range_m)
        self.visible[index] = ids
        self.ever_seen[ids] = True
        ids = ids[known.open[ids]]
        ranges = sensor.measure(true_ranges[known.open[self.visible[index]]], self._rng)
        places = self.world.layout.positions_en_m[ids]
        eye = point(self.positions[index])
        sealed = known.observe(ids, *heights_from_ranges(sensor, eye, places, ranges, known.heights_m[ids]))
        self.sealed_by[index] = int(np.count_nonzero(~self.accurate[sealed]))
        self.accurate[sealed] = True
        self._exchanges[index].sensed(self.visible[index], sealed)

    def _tell(self) -> None:
        packets: dict[int, Packet] = {}
        for index in np.flatnonzero(self.present).tolist():
            place = point(self.positions[index])
            packets[index] = self._exchanges[index].packet(place, self.teammates(self.in_radio(index)))
            message = message_of(index, self.steps, place, self.goals[index], packets[index])
            self.bytes_sent += len(self._codec.encode(message))
        for index in packets:
            self.heard[index] = self.in_radio(index)
            if self._trouble.loss > 0.0:
                self.heard[index] &= self._rng.random(self.vehicles) >= self._trouble.loss
            heard = {other: packets[other] for other in np.flatnonzero(self.heard[index]).tolist()}
            taken = self._exchanges[index].take(heard, point(self.positions[index]))
            self.accurate[self.maps[index].merge(taken).sealed] = True

    def teammates(self, known: BoolArray) -> tuple[Teammate, ...]:
        """Those of the team that are `known`, (vehicles,), where they are and where they go."""
        return tuple(
            Teammate(other, point(self.positions[other]), self.goals[other]) for other in np.flatnonzero(known).tolist()
        )

    def said_done(self, index: int) -> BoolArray | None:
        """What a vehicle was told to be done without more."""
        return self._exchanges[index].said_done

    # Figures

    def remaining_percent(self) -> float:
        return 100.0 * float(np.mean(~self.accurate))

    def error(self) -> float:
        """Length of the vector of all landmarks' errors (eq. 25), each landmark as its best estimator has it.

        A landmark that nobody has measured counts as supposed at height 0.
        """
        deviations = np.array([known.sd_m for known in self.maps])
        best = np.argmin(deviations, axis=0)
        heights = np.array([known.heights_m for known in self.maps])[best, np.arange(len(best))]
        return float(np.linalg.norm(np.nan_to_num(heights) - self.world.heights))

    def repair(self) -> bool:
        """Let all living vehicles tell each other everything; whether their maps agree then."""
        living = [known for known, present in zip(self.maps, self.present, strict=True) if present]
        for _ in range(3):
            for known in living:
                for other in living:
                    known.merge(other.records())
        return all(
            known == living[0] and np.array_equal(known.heights_m, living[0].heights_m, equal_nan=True)
            for known in living
        )


class Mover(Protocol):
    """Moves a team by one step."""

    def move(self, team: Team) -> Sequence[float]:
        """Set `team.positions`; return the planning time of each decision, milliseconds."""
        ...


def run_team(team: Team, mover: Mover, steps: int) -> MappingRun:
    """Run a team for so many steps; it stops early when every landmark is accurate."""
    team.sense_and_tell()
    track, curve, error = [team.positions.copy()], [team.remaining_percent()], team.error()
    step_ms, step_done = list[float](), list[float]()
    for _ in range(steps):
        if curve[-1] > 0.0:
            step_ms.extend(mover.move(team))
            step_done.extend([100.0 - curve[-1]] * (len(step_ms) - len(step_done)))
            team.sense_and_tell()
        track.append(team.positions.copy())
        curve.append(team.remaining_percent())
        error += team.error()
    return MappingRun(np.array(track), np.array(curve), error, team.bytes_sent, step_ms, step_done, team.repair())


def start_positions(world: World, vehicles: int) -> FloatArray:
    """A lattice in the south-western corner, (vehicles, 3), each in radio range of its neighbours."""
    side = int(np.ceil(np.sqrt(vehicles)))
    first = -1.0 + 0.5 * START_SPACING_M
    places = np.array(
        [(first + START_SPACING_M * (n % side), first + START_SPACING_M * (n // side)) for n in range(vehicles)]
    )
    heights = world.heights_at(places)
    return np.column_stack((places, np.full(vehicles, heights.max() + FIRST_HEIGHT_M)))


def point(place: FloatArray) -> Point:
    return (float(place[0]), float(place[1]), float(place[2]))


def timed(began_s: float) -> float:
    """Milliseconds since a reading of the performance counter."""
    return 1e3 * (time.perf_counter() - began_s)
