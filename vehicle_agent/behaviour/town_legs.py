"""Straight legs between buildings: when one counts as flown, from which speed it may begin, and what air it needs."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.behaviour.leg import Leg, braking_distance_m, speed_m_s
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.ports import VehicleState

ARRIVED_M, SLOW_M_S = 0.5, 0.6
"""Near enough to the end of a leg between buildings, and slow enough to turn to any side."""
SIDEWAYS_M_S = 0.8
"""Speed across a new leg with which it may be begun in flight: the vehicle overshoots it by some decimetres."""
SAMPLES_PER_VOXEL = 4


def is_flown(leg: Leg, state: VehicleState) -> bool:
    """Arrived and slow."""
    return math.dist(leg.end_enu_m, state.position_enu_m) <= ARRIVED_M and speed_m_s(state) <= SLOW_M_S


def leads_to(leg: Leg, place_enu_m: Point) -> bool:
    """Whether a leg ends at a place already."""
    return math.dist(leg.end_enu_m, place_enu_m) < ARRIVED_M


def turns(state: VehicleState, end_enu_m: Point) -> bool:
    """Whether the vehicle would be carried beside a leg to there, or past its end."""
    velocity, away = np.array(state.velocity_enu_m_s), np.subtract(end_enu_m, state.position_enu_m)
    length = float(np.linalg.norm(away))
    if length == 0.0:
        return speed_m_s(state) > SLOW_M_S
    along = float(velocity @ away) / length
    across = math.sqrt(max(0.0, float(velocity @ velocity) - along**2))
    return across > SIDEWAYS_M_S or along < -SIDEWAYS_M_S or braking_distance_m(state) > length


def is_clear(passable: BoolArray, grid: VoxelGrid, start_enu_m: Point, end_enu_m: Point) -> bool:
    """Whether a straight line runs through passable voxels, (U, V, W) bool; what is beside its start does not count."""
    away = np.subtract(end_enu_m, start_enu_m)
    length = float(np.linalg.norm(away)) / grid.voxel_m
    if length == 0.0:
        return True
    places = np.arange(0.0, length, 1.0 / SAMPLES_PER_VOXEL)
    places = np.append(places[places > 1.5], length)
    points = np.array(start_enu_m) + places[:, None] / length * away
    voxels = np.floor((points - grid.corner_enu_m) / grid.voxel_m).astype(np.int64)
    if (voxels < 0).any() or (voxels >= np.array(grid.shape)).any():
        return False
    return bool(passable[tuple(voxels.T)].all())
