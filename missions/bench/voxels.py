"""Voxel insertion against OctoMap: the same scans into both, how fast, and whether they agree on what is where."""

from __future__ import annotations

import importlib
import importlib.util
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from missions.bench.results import Row, save_rows, work_through
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxels import FREE, OCCUPIED, UNKNOWN, VoxelMap
from vehicle_agent.mission.load import MissionError

VOXEL_M = 0.2
RANGE_M = 10.0
RAYS = 10_000
RIVALS = ("octomap", "pyoctomap")
"""Modules of octomap-python and pyoctomap; those installed are measured."""
HALL_M = (40.0, 30.0, 8.0)
"""Inner size of the scanned hall: its walls are partly beyond range, so that some rays are cut."""


class Rival(Protocol):
    """One of OctoMap's Python bindings."""

    def insertPointCloud(self, points: FloatArray, origin: FloatArray, maxrange: float) -> Any: ...  # noqa: N802

    def begin_leafs(self) -> Any: ...

    def isNodeOccupied(self, node: Any) -> bool: ...  # noqa: N802


@dataclass(frozen=True, slots=True)
class Scan:
    """One scan.

    Attributes
    ----------
    sensor_enu_m : (3,) float64.
    ends_enu_m : (RAYS, 3) float64; all coordinates are 32-bit floats, which is what OctoMap computes with.
    """

    sensor_enu_m: FloatArray
    ends_enu_m: FloatArray


@dataclass(frozen=True, slots=True)
class SceneResult:
    """Both maps after the same scans of one scene.

    Attributes
    ----------
    rival
        Module of OctoMap's binding.
    rays_s, octomap_rays_s
        Rays per second of wall time, in the median scan.
    known_agreement, state_agreement
        Of the voxels known to either map, the share known to both; of these, the share with the same state.
    occupied, octomap_occupied
        Voxels occupied in each map.
    """

    rival: str
    seed: int
    rays_s: float
    octomap_rays_s: float
    known_agreement: float
    state_agreement: float
    occupied: int
    octomap_occupied: int

    @property
    def ratio(self) -> float:
        return self.rays_s / self.octomap_rays_s


def bench_voxels(seed: int, scenes: int, scans: int, json_file: Path | None) -> int:
    """Measure scene after scene, print, save; returns the exit code. MissionError without OctoMap."""
    rivals = [name for name in RIVALS if importlib.util.find_spec(name) is not None]
    if not rivals:
        raise MissionError(
            "missions bench voxels compares with OctoMap; install it with pip install 'fieldfleet[bench]'"
        )
    for rival in rivals:
        _measure_scene(rival, seed, 1)  # compiles and loads
    cases = [(rival, scene) for scene in range(seed, seed + scenes) for rival in rivals]
    results, stopped = work_through(cases, lambda case: _measure_scene(*case, scans), "voxels")
    if json_file is not None:
        save_rows(json_file, "voxels", seed, [_row(result, scans) for result in results])
    for result in results:
        print(
            f"scene {result.seed:>4}: {result.rays_s / 1e3:5.0f} k rays/s, {result.rival} "
            f"{result.octomap_rays_s / 1e3:4.0f} k, ratio {result.ratio:5.1f}; "
            f"{100 * result.known_agreement:.2f} % of known voxels known to both, "
            f"{100 * result.state_agreement:.3f} % of these alike"
        )
    for rival in rivals:
        ratios = np.array([result.ratio for result in results if result.rival == rival])
        if len(ratios):
            spread = ratios.std(ddof=1) if len(ratios) > 1 else 0.0
            print(f"{rival}: ratio {ratios.mean():.1f} sd {spread:.1f}, {ratios.min():.1f} to {ratios.max():.1f}")
    return 130 if stopped else 0


def _row(result: SceneResult, scans: int) -> Row:
    return {
        "scene": result.seed,
        "rival": result.rival,
        "scans": scans,
        "rays_per_scan": RAYS,
        "voxel_m": VOXEL_M,
        "range_m": RANGE_M,
        "rays_s": round(result.rays_s),
        "octomap_rays_s": round(result.octomap_rays_s),
        "ratio": round(result.ratio, 2),
        "known_agreement": round(result.known_agreement, 6),
        "state_agreement": round(result.state_agreement, 6),
        "occupied": result.occupied,
        "octomap_occupied": result.octomap_occupied,
    }


def _measure_scene(rival_name: str, seed: int, scans: int) -> SceneResult:
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(2000,)))
    boxes = _draw_boxes(rng)
    taken = [_scan(boxes, rng) for _ in range(scans)]
    width, depth, height = HALL_M
    size = [round((length + 4.0) / VOXEL_M) for length in (width, depth, height)]
    grid = VoxelGrid(-2.0, -2.0, -2.0, VOXEL_M, *size)
    ours, rival = VoxelMap(grid), _new_rival(rival_name)
    # Scan by scan in turn, so that whatever else the machine does falls on both.
    seconds = np.empty((2, scans))
    for number, scan in enumerate(taken):
        began_s = time.perf_counter()
        ours.insert(0, tuple(scan.sensor_enu_m), scan.ends_enu_m, RANGE_M, number)
        between_s = time.perf_counter()
        rival.insertPointCloud(scan.ends_enu_m, scan.sensor_enu_m, RANGE_M)
        ended_s = time.perf_counter()
        seconds[:, number] = between_s - began_s, ended_s - between_s
    ours_s, rival_s = np.median(seconds, axis=1)
    states = ours.states().ravel()
    labels = _rival_states(rival, grid)
    either, both = (states > 0) | (labels > 0), (states > 0) & (labels > 0)
    return SceneResult(
        rival=rival_name,
        seed=seed,
        rays_s=RAYS / float(ours_s),
        octomap_rays_s=RAYS / float(rival_s),
        known_agreement=float(both.sum() / either.sum()),
        state_agreement=float((states[both] == labels[both]).mean()),
        occupied=int((states == OCCUPIED).sum()),
        octomap_occupied=int((labels == OCCUPIED).sum()),
    )


def _new_rival(binding: str) -> Rival:
    tree: Rival = importlib.import_module(binding).OcTree(VOXEL_M)
    return tree


def _rival_states(rival: Rival, grid: VoxelGrid) -> npt.NDArray[np.uint8]:
    """OctoMap's states of all voxels in our words: (voxels,) uint8."""
    states = np.full(grid.shape, UNKNOWN, dtype=np.uint8)
    for leaf in rival.begin_leafs():
        size_m = leaf.getSize()  # a leaf may stand for many voxels of one state
        low = (np.array(leaf.getCoordinate()) - 0.5 * size_m - grid.corner_enu_m) / grid.voxel_m
        first = np.maximum(np.rint(low).astype(np.int64), 0)
        last = np.maximum(np.rint(low + size_m / grid.voxel_m).astype(np.int64), 0)
        state = OCCUPIED if rival.isNodeOccupied(leaf) else FREE
        states[first[0] : last[0], first[1] : last[1], first[2] : last[2]] = state
    return states.ravel()


def _draw_boxes(rng: np.random.Generator) -> FloatArray:
    """Boxes that stand in the hall: (B, 2, 3) float64, lowest and highest corners, ENU metres."""
    low = np.column_stack((rng.uniform(1.0, HALL_M[0] - 4.0, 25), rng.uniform(1.0, HALL_M[1] - 4.0, 25), np.zeros(25)))
    size = np.column_stack((rng.uniform(0.5, 3.0, 25), rng.uniform(0.5, 3.0, 25), rng.uniform(1.0, 6.0, 25)))
    return np.stack((low, low + size), axis=1)


def _scan(boxes: FloatArray, rng: np.random.Generator) -> Scan:
    """A scan in directions spread evenly at random, from a place outside all boxes."""
    while True:
        sensor = rng.uniform((1.0, 1.0, 0.5), np.array(HALL_M) - 1.0).astype(np.float32).astype(np.float64)
        if not ((sensor > boxes[:, 0]) & (sensor < boxes[:, 1])).all(axis=1).any():
            break
    directions = rng.normal(size=(RAYS, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    hall = np.where(directions > 0, (np.array(HALL_M) - sensor) / directions, -sensor / directions).min(axis=1)
    lengths = np.minimum(hall, _box_distances(boxes, sensor, directions))
    ends = sensor + directions * lengths[:, None]
    return Scan(sensor, ends.astype(np.float32).astype(np.float64))


def _box_distances(boxes: FloatArray, sensor: FloatArray, directions: FloatArray) -> FloatArray:
    """Distance along each direction to the nearest box, infinite when there is none: (RAYS,) float64."""
    first = (boxes[:, None, 0] - sensor) / directions
    second = (boxes[:, None, 1] - sensor) / directions
    enter, leave = np.minimum(first, second).max(axis=2), np.maximum(first, second).min(axis=2)
    distances: FloatArray = np.where((enter <= leave) & (enter > 0), enter, np.inf).min(axis=0)
    return distances
