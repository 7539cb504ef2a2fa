"""How simulated bodies move: within their limits, straight, without overshoot, and stopped by the ground."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sim_bridge.dynamics import Bodies, Motion
from sim_bridge.laws import JERK_M_S3
from sim_bridge.world import World
from vehicle_agent.domain.grid import Grid

STEP_S = 0.05
OVERSHOOT_M_S = 0.02
LEVEL = World(Grid(-2000.0, -2000.0, 400.0, 10, 10), np.full((10, 10), -1000.0))
offsets = st.floats(-500.0, 500.0, allow_nan=False)


def airborne(world: World = LEVEL, up_m: float = 0.0) -> Bodies:
    bodies = Bodies(world, np.zeros((1, 2)))
    bodies.position_enu_m[0, 2] = up_m
    bodies.limits[0] = [15.0, 5.0, 3.0, 2.5, 1.0, 0.0]
    return bodies


@settings(max_examples=25, deadline=None)
@given(target=st.tuples(offsets, offsets, offsets))
def test_a_leg_from_rest_is_straight_within_limits_and_ends_at_its_target(target: tuple[float, float, float]) -> None:
    bodies = airborne()
    goal = np.array(target)
    bodies.motion[0], bodies.target[0] = Motion.POSITION, goal
    positions, velocities = [], [np.zeros(3)]
    for _ in range(4_500):
        bodies.advance(STEP_S)
        positions.append(bodies.position_enu_m[0].copy())
        velocities.append(bodies.velocity_enu_m_s[0].copy())
    way, velocity = np.array(positions), np.array(velocities)
    change = np.diff(velocity, axis=0) / STEP_S
    assert np.hypot(velocity[:, 0], velocity[:, 1]).max() <= 15.0 + OVERSHOOT_M_S
    assert velocity[:, 2].max() <= 5.0 + OVERSHOOT_M_S
    assert velocity[:, 2].min() >= -3.0 - OVERSHOOT_M_S
    assert np.hypot(change[:, 0], change[:, 1]).max() <= 2.5 + 1e-6
    assert np.abs(change[:, 2]).max() <= 1.0 + 1e-6
    assert np.linalg.norm(np.diff(change, axis=0), axis=1).max() <= JERK_M_S3 * STEP_S + 1e-6
    length = float(np.linalg.norm(goal))
    if length > 1e-3:
        along = way @ goal / length
        assert along.max() <= length + 0.05
        assert np.linalg.norm(way - along[:, None] * goal / length, axis=1).max() < 0.1
    assert float(np.linalg.norm(bodies.position_enu_m[0] - goal)) < 0.05


@settings(max_examples=15, deadline=None)
@given(first=st.tuples(offsets, offsets), second=st.tuples(offsets, offsets), seconds=st.integers(1, 40))
def test_a_new_target_in_mid_flight_is_reached_too(
    first: tuple[float, float], second: tuple[float, float], seconds: int
) -> None:
    bodies = airborne()
    bodies.motion[0], bodies.target[0] = Motion.POSITION, (*first, 0.0)
    for _ in range(seconds * 20):
        bodies.advance(STEP_S)
    bodies.target[0] = (*second, 0.0)
    for _ in range(4_500):
        bodies.advance(STEP_S)
    assert float(np.linalg.norm(bodies.position_enu_m[0] - bodies.target[0])) < 0.05


def test_velocity_targets_are_clipped_to_the_limits() -> None:
    bodies = airborne()
    bodies.motion[0], bodies.target[0] = Motion.VELOCITY, (300.0, -400.0, 99.0)
    for _ in range(400):
        bodies.advance(STEP_S)
    np.testing.assert_allclose(bodies.velocity_enu_m_s[0], [9.0, -12.0, 5.0], atol=1e-9)


def test_heading_turns_to_the_course() -> None:
    bodies = airborne()
    bodies.motion[0], bodies.target[0] = Motion.VELOCITY, (-5.0, 0.0, 0.0)
    for _ in range(400):
        bodies.advance(STEP_S)
    assert abs(bodies.heading_deg[0] - 270.0) < 1e-6


def test_without_thrust_it_falls_and_the_ground_stops_it() -> None:
    bodies = airborne(World(Grid(-100.0, -100.0, 100.0, 2, 2), np.zeros((2, 2))), up_m=20.0)
    impacts = []
    for _ in range(100):
        bodies.advance(STEP_S)
        impacts.append(float(bodies.impact_m_s[0]))
    speed = max(impacts)
    assert abs(speed - np.sqrt(2 * 9.80665 * 20.0)) < 0.6
    assert bodies.position_enu_m[0, 2] == 0.0
    assert not bodies.velocity_enu_m_s.any()


def test_a_slope_in_the_way_is_hit_at_flying_speed() -> None:
    elevation = np.repeat(np.array([0.0, 0.0, 0.0, 500.0])[:, None], 2, axis=1)
    bodies = airborne(World(Grid(-200.0, -100.0, 100.0, 4, 2), elevation), up_m=30.0)
    bodies.motion[0], bodies.target[0] = Motion.POSITION, (1000.0, 0.0, 30.0)
    hit = 0.0
    for _ in range(400):
        bodies.advance(STEP_S)
        hit = max(hit, float(bodies.impact_m_s[0]))
    assert hit > 5.0
    assert bodies.position_enu_m[0, 2] >= 0.0


def test_bodies_do_not_disturb_each_other() -> None:
    alone, together = airborne(), Bodies(LEVEL, np.zeros((3, 2)))
    together.position_enu_m[:, 2] = 0.0
    together.limits[:] = alone.limits[0]
    alone.motion[0], alone.target[0] = Motion.POSITION, (100.0, 50.0, 30.0)
    together.motion[1], together.target[1] = Motion.POSITION, (100.0, 50.0, 30.0)
    together.motion[2], together.target[2] = Motion.VELOCITY, (1.0, 2.0, 3.0)
    for _ in range(200):
        alone.advance(STEP_S)
        together.advance(STEP_S)
    np.testing.assert_array_equal(alone.position_enu_m[0], together.position_enu_m[1])
