"""CAO as an optimiser: its basis, its convergence, its obedience to constraints and to its dice."""

from __future__ import annotations

import doctest

import numpy as np
import pytest

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.polynomials import cubic_monomials
from vehicle_agent.planning import cao
from vehicle_agent.planning.cao import BASIS_FUNCTIONS, Cao, CaoParams


def anywhere(ends: FloatArray) -> BoolArray:
    return np.ones(len(ends), dtype=np.bool_)


def test_the_example_in_the_documentation_runs() -> None:
    results = doctest.testmod(cao)
    assert results.attempted > 0
    assert results.failed == 0


def test_the_third_degree_basis_of_three_variables_has_twenty_functions() -> None:
    assert BASIS_FUNCTIONS == 20
    points = np.random.default_rng(0).standard_normal((100, 3))
    assert np.linalg.matrix_rank(cubic_monomials(points)) == 20


def test_any_cubic_is_estimated_exactly_from_a_full_window() -> None:
    rng = np.random.default_rng(1)
    weights = rng.standard_normal(20)

    def cubic(points: FloatArray) -> FloatArray:
        values: FloatArray = cubic_monomials(points / 100.0) @ weights
        return values

    optimiser = Cao(CaoParams(step_m=30.0), rng)
    here = np.array([200.0, -100.0, 50.0])
    for position in here + rng.uniform(-60.0, 60.0, (30, 3)):
        optimiser.tell((position[0], position[1], position[2]), float(cubic(position[None])[0]))
    candidates = here + rng.uniform(-30.0, 30.0, (10, 3))
    assert np.allclose(optimiser._promise(candidates, here, 30.0), cubic(candidates), atol=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_a_shrinking_step_converges_on_a_quadratic(seed: int) -> None:
    top = np.array([40.0, -25.0, 10.0])
    optimiser = Cao(CaoParams(step_m=5.0), np.random.default_rng(seed))
    position: Point = (0.0, 0.0, 0.0)
    for step in range(300):
        optimiser.tell(position, -float(np.sum((np.array(position) - top) ** 2)))
        moved = optimiser.ask(position, anywhere, step_m=5.0 / (1.0 + step) ** 0.5)
        assert moved is not None
        position = moved
    assert np.linalg.norm(np.array(position) - top) < 1.5


def test_every_step_has_its_length() -> None:
    optimiser = Cao(CaoParams(step_m=7.0), np.random.default_rng(0))
    for step_m in (None, 2.0):
        end = optimiser.ask((1.0, 2.0, 3.0), anywhere, step_m)
        assert end is not None
        assert np.linalg.norm(np.subtract(end, (1.0, 2.0, 3.0))) == pytest.approx(step_m or 7.0)


def test_only_admissible_perturbations_are_taken() -> None:
    optimiser = Cao(CaoParams(step_m=1.0), np.random.default_rng(0))
    position: Point = (0.0, 0.0, 0.0)
    for _ in range(50):
        optimiser.tell(position, position[0])
        end = optimiser.ask(position, lambda ends: ends[:, 0] < 3.0)
        assert end is not None
        assert end[0] < 3.0
        position = end
    assert optimiser.ask(position, lambda ends: np.zeros(len(ends), dtype=np.bool_)) is None


def test_the_same_dice_give_the_same_steps_and_others_do_not() -> None:
    def walk(seed: int) -> list[Point | None]:
        optimiser = Cao(CaoParams(step_m=1.0), np.random.default_rng(seed))
        ends: list[Point | None] = []
        for number in range(5):
            optimiser.tell((float(number), 0.0, 0.0), float(number))
            ends.append(optimiser.ask((0.0, 0.0, 0.0), anywhere))
        return ends

    assert walk(3) == walk(3)
    assert walk(3) != walk(4)


def test_only_the_window_is_remembered() -> None:
    params, measured = CaoParams(step_m=1.0, extra_window=2), np.random.default_rng(1).uniform(0.0, 5.0, (23, 4))
    asked = []
    for first in (0, 1, 2):
        optimiser = Cao(params, np.random.default_rng(0))
        for east, north, up, objective in measured[first:]:
            optimiser.tell((east, north, up), objective)
        asked.append([optimiser.ask((1.0, 1.0, 1.0), anywhere) for _ in range(20)])
    assert asked[0] == asked[1]  # the first of 23 is beyond the window of 22
    assert asked[1] != asked[2]


@pytest.mark.parametrize(
    "wrong", [{"step_m": 0.0}, {"step_m": 1.0, "candidates": 0}, {"step_m": 1.0, "extra_window": -1}]
)
def test_impossible_parameters_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must"):
        CaoParams(**wrong)  # type: ignore[arg-type]
