"""Surveys of one sea floor with echo sounders: by a fleet that looks where it pays, and by lines sailed to and fro."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates

from missions.terrain.sea_floor import CELL_M, SIDE_M, FloorName, floor_strength, sea_floor
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.relief import Relief
from vehicle_agent.planning.mapping.survey import Survey, SurveyParams
from vehicle_agent.planning.mapping.survey_lines import Box, parallel_lines

VEHICLES = 2
STEPS = 500
STEP_M = 2.0
SPEED_M_S = 1.0
DEPTH_M = 3.0
NOISE_SHARE = 0.005
"""Standard deviation of a sounding over its range (Kapoutsis 2015, eq. 24)."""
CAPACITY = 10
"""Soundings in the packet that a vehicle tells its teammate at every step."""
MORE_SAMPLES = 7.503
"""Samples of the usual practice in the paper's table 2 over those of its fleet."""
BLOCK_SAMPLES = 1_500
"""More soundings than these are averaged along the track before a relief is fitted: neighbours within centimetres."""
MAP_CELL_M = 1.0
AREA = Box(0.0, 0.0, SIDE_M, SIDE_M)


@dataclass(frozen=True, slots=True)
class Soundings:
    """What an echo sounder found.

    Attributes
    ----------
    places_en_m : (N, 2) float64, where.
    heights_m : (N,) float64, ENU z of the floor as measured.
    sds_m : (N,) float64, their standard deviation.
    """

    places_en_m: FloatArray
    heights_m: FloatArray
    sds_m: FloatArray

    def __len__(self) -> int:
        return len(self.places_en_m)

    @classmethod
    def joined(cls, parts: list[Soundings]) -> Soundings:
        return cls(
            np.concatenate([part.places_en_m for part in parts]),
            np.concatenate([part.heights_m for part in parts]),
            np.concatenate([part.sds_m for part in parts]),
        )

    def __getitem__(self, rows: slice) -> Soundings:
        return Soundings(self.places_en_m[rows], self.heights_m[rows], self.sds_m[rows])


@dataclass(frozen=True, slots=True)
class Outcome:
    """One survey of one floor."""

    floor: FloorName
    seed: int
    method: str
    samples: int
    l2_error: float
    time_s: float
    places_en_m: FloatArray


class EchoSounder:
    """Measures a floor from a constant depth."""

    def __init__(self, floor_m: FloatArray, rng: np.random.Generator) -> None:
        self._floor_m, self._rng = floor_m, rng

    def sound(self, places_en_m: FloatArray) -> Soundings:
        """One sounding at every place, (N, 2) ENU metres."""
        truth = on_floor(self._floor_m, places_en_m)
        sds = NOISE_SHARE * (-DEPTH_M - truth)
        heights = truth + sds * self._rng.standard_normal(len(truth))
        # A vehicle knows its noise only by the range that it measured.
        return Soundings(places_en_m, heights, NOISE_SHARE * np.maximum(-DEPTH_M - heights, 0.5))


def l2_error(floor_m: FloatArray, soundings: Soundings) -> float:
    """L2 norm of the difference between the true map and the one drawn from soundings, over cells of 1 m (section 7.3).

    Every method's map is drawn by the same `Relief`.
    """
    soundings = _averaged(soundings)
    fold = round(MAP_CELL_M / CELL_M)
    cells = len(floor_m) // fold
    truth = floor_m.reshape(cells, fold, cells, fold).mean(axis=(1, 3))
    centres = (np.arange(cells) + 0.5) * MAP_CELL_M
    places = np.stack(np.meshgrid(centres, centres, indexing="ij"), axis=-1).reshape(-1, 2)
    drawn = Relief(soundings.places_en_m, soundings.heights_m, soundings.sds_m).heights_at(places)
    return float(np.linalg.norm(drawn - truth.ravel()))


def survey_by_fleet(floor: FloorName, seed: int, params: SurveyParams, informed: bool = False) -> Outcome:
    """Two vehicles, each deciding alone from what it sounded and was told.

    `informed` is the yardstick: somebody told them how rough the floor is everywhere, so they need not find out.
    """
    floor_m = sea_floor(floor, seed)
    strength = floor_strength(floor, seed) if informed else None
    streams = np.random.SeedSequence(seed, spawn_key=(3_100,)).spawn(VEHICLES)
    vehicles = [
        _Surveyor(index, EchoSounder(floor_m, np.random.default_rng(streams[index])), params, strength)
        for index in range(VEHICLES)
    ]
    for _ in range(STEPS):
        for vehicle in vehicles:
            vehicle.step()
        for vehicle in vehicles:
            for other in vehicles:
                if other is not vehicle:
                    other.hear(vehicle.tell())
        for vehicle in vehicles:
            vehicle.told()
    soundings = Soundings.joined([vehicle.own for vehicle in vehicles])
    slowest_m = max(vehicle.gone_m for vehicle in vehicles)
    return Outcome(
        floor, seed, "informed" if informed else "fleet", len(soundings), l2_error(floor_m, soundings),
        slowest_m / SPEED_M_S, soundings.places_en_m,
    )  # fmt: skip


def survey_by_lines(floor: FloorName, seed: int, samples: int) -> Outcome:
    """The usual practice: two vehicles sail parallel lines, as long as the fleet may, sounding at a fixed rate.

    Lines along both axes are tried, and the better counts.
    """
    floor_m = sea_floor(floor, seed)
    streams = np.random.SeedSequence(seed, spawn_key=(3_200, samples)).spawn(2)
    outcomes = []
    for turned in range(2):
        tracks = [_usual_track(index, bool(turned)) for index in range(VEHICLES)]
        sounder = EchoSounder(floor_m, np.random.default_rng(streams[turned]))
        lengths = [_length_m(track) for track in tracks]
        share = [samples // VEHICLES + (index < samples % VEHICLES) for index in range(VEHICLES)]
        soundings = Soundings.joined(
            [sounder.sound(_spread(track, count)) for track, count in zip(tracks, share, strict=True)]
        )
        outcomes.append(
            Outcome(
                floor, seed, "lawnmower", len(soundings), l2_error(floor_m, soundings), max(lengths) / SPEED_M_S,
                soundings.places_en_m,
            )
        )  # fmt: skip
    return min(outcomes, key=lambda outcome: outcome.l2_error)


class _Surveyor:
    """One vehicle of the fleet.

    Attributes
    ----------
    own
        Everything that it sounded.
    place
        Where it is, east and north.
    gone_m
        What it has sailed.
    """

    def __init__(
        self, index: int, sounder: EchoSounder, params: SurveyParams, known_strength: FloatArray | None
    ) -> None:
        self._survey = Survey(AREA, index, VEHICLES, params)
        self._teammates = [other for other in range(VEHICLES) if other != index]
        self._sounder = sounder
        self._strengths = None
        self._way = self._survey.first_lines((SIDE_M * index, 0.0))
        if known_strength is not None:
            self._strengths = on_floor(known_strength, self._survey.nodes_en_m)
            self._way = self._way[:1]
        self._known: list[Soundings] = []
        self._untold: list[Soundings] = []
        self._next = 1
        self._left_in_part_m = math.inf
        self.place = (float(self._way[0, 0]), float(self._way[0, 1]))
        self.gone_m = 0.0
        self._own: list[Soundings] = []

    @property
    def own(self) -> Soundings:
        return Soundings.joined(self._own)

    def step(self) -> None:
        """Sail at most `STEP_M` to the next stop of the way and sound there."""
        if self._own:
            self._sail()
        sounding = self._sounder.sound(np.array([self.place]))
        self._own.append(sounding)
        self._known.append(sounding)
        self._untold.append(sounding)

    def tell(self) -> list[Soundings]:
        """The next packet: what it has sounded and not told yet, the oldest first."""
        return self._untold[:CAPACITY]

    def told(self) -> None:
        """The packet is out."""
        del self._untold[:CAPACITY]

    def hear(self, packet: list[Soundings]) -> None:
        self._known += packet

    def _sail(self) -> None:
        if self._next >= len(self._way) or self._left_in_part_m <= 0.0:
            self._decide()
        if self._next >= len(self._way):
            return
        stop = self._way[self._next]
        away_m = math.dist(self.place, stop)
        share = 1.0 if away_m <= STEP_M + 1e-6 else STEP_M / away_m
        self.place = (
            float(self.place[0] + share * (stop[0] - self.place[0])),
            float(self.place[1] + share * (stop[1] - self.place[1])),
        )
        self.gone_m += share * away_m
        self._left_in_part_m -= STEP_M
        self._next += share == 1.0

    def _decide(self) -> None:
        known = Soundings.joined(self._known)
        strengths = self._strengths
        if strengths is None:
            strengths = self._survey.roughness(Relief(known.places_en_m, known.heights_m, known.sds_m))
        left_m = (STEPS - len(self._own)) * STEP_M
        planned = self._way[self._next :]
        self._way = self._survey.next_way(
            self.place, strengths, known.places_en_m, left_m, self._teammates, planned_en_m=planned
        )
        self._next, self._left_in_part_m = 1, self._survey.params.part_m


def on_floor(grid_values: FloatArray, places_en_m: FloatArray) -> FloatArray:
    """Values of a floor's cells at places: (200, 200), (N, 2) -> (N,)."""
    values: FloatArray = map_coordinates(grid_values, (places_en_m / CELL_M - 0.5).T, order=1, mode="nearest")
    return values


def _usual_track(index: int, turned: bool) -> FloatArray:
    """One vehicle's lines, as close together as the length that the fleet may sail allows: (K, 2) ENU metres."""
    strip = AREA.lane(index, VEHICLES)
    spacing_m = strip.area_m2 / (STEPS * STEP_M)
    track = parallel_lines(strip, spacing_m, 0.5 * spacing_m, (strip.west_m, strip.south_m))
    return track[:, ::-1] if turned else track


def _length_m(track: FloatArray) -> float:
    return float(np.hypot(*np.diff(track, axis=0).T).sum())


def _spread(track: FloatArray, count: int) -> FloatArray:
    """So many places evenly along a track, its ends among them."""
    gone = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(track, axis=0).T))))
    at = np.linspace(0.0, gone[-1], count)
    return np.column_stack([np.interp(at, gone, track[:, axis]) for axis in (0, 1)])


def _averaged(soundings: Soundings) -> Soundings:
    """Neighbours along the track averaged, so that a relief of many soundings stays possible."""
    block = math.ceil(len(soundings) / BLOCK_SAMPLES)
    if block == 1:
        return soundings
    starts = np.arange(0, len(soundings), block)
    counts = np.diff(np.append(starts, len(soundings)))
    return Soundings(
        np.add.reduceat(soundings.places_en_m, starts) / counts[:, None],
        np.add.reduceat(soundings.heights_m, starts) / counts,
        np.sqrt(np.add.reduceat(soundings.sds_m**2, starts)) / counts,
    )
