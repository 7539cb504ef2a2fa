"""The transformed objective and its optimisers: switches that deadlocks throw, candidates that keep the constraints."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.mapping.cao_mapping import MappingCao, MappingCaoParams
from vehicle_agent.planning.mapping.objective import Objective, ObjectiveParams, Outlook
from vehicle_agent.planning.mapping.osarses import Osarses


def outlook(sealed: float, visible: list[int], near_sum: float = 4.0, far_sum: float = 10.0) -> Outlook:
    return Outlook(sealed, np.array(visible), near_sum, far_sum)


def objective(terms: str) -> Objective:
    params = ObjectiveParams(
        terms,
        visible_weight=0.5,
        nearness_weight=0.1,
        far_weight=0.01,
        visible_tolerance=0.6,
        nearness_tolerance=0.6,
    )
    return Objective(params, vehicles=2)


def test_only_the_rate_of_sealing_counts_while_nobody_is_stuck() -> None:
    whole = objective("all")
    whole.record(np.array([3, 1]), outlook(4, [5, 5]))
    assert whole.value(outlook(2, [7, 8])) == 2.0


def test_a_deadlock_switches_its_vehicle_to_visible_landmarks_and_nearness() -> None:
    whole = objective("all")
    whole.record(np.array([3, 0]), outlook(3, [5, 5]))
    assert whole.value(outlook(2, [7, 8])) == pytest.approx(2 + 0.5 * 8 - 0.1 * 4.0)


def test_a_vehicle_that_gains_nothing_any_more_is_drawn_to_far_landmarks() -> None:
    whole = objective("all")
    for _ in range(3):
        whole.record(np.array([3, 0]), outlook(3, [5, 5]))
    assert whole.value(outlook(2, [7, 8])) == pytest.approx(2 + 0.5 * 8 - 0.1 * 4.0 - 0.01 * 10.0)
    whole.record(np.array([3, 0]), outlook(3, [5, 9]))
    assert whole.value(outlook(2, [7, 8])) == pytest.approx(2 + 0.5 * 8 - 0.1 * 4.0)


@pytest.mark.parametrize(
    ("terms", "value"), [("J", 2.0), ("J+J1", 6.0), ("J+J1+J2", 5.6), ("J+J1+J3", 5.9), ("all", 5.5)]
)
def test_the_ablation_leaves_terms_out(terms: str, value: float) -> None:
    part = objective(terms)
    for _ in range(3):
        part.record(np.array([3, 0]), outlook(3, [5, 5]))
    assert part.value(outlook(2, [7, 8])) == pytest.approx(value)


def test_unknown_terms_are_refused() -> None:
    with pytest.raises(ValueError, match="terms must be one of"):
        ObjectiveParams("J4")


def in_box(_index: int, ends: FloatArray) -> FloatArray:
    return ends[(np.abs(ends) <= 1.0).all(axis=1)]


def together(teams: FloatArray) -> BoolArray:
    near: BoolArray = np.linalg.norm(teams[:, 0] - teams[:, 1], axis=1) <= 0.3
    return near


def height(positions: FloatArray) -> float:
    return float(positions[:, 2].sum())


def test_osarses_takes_the_best_of_what_it_really_tries() -> None:
    rng = np.random.default_rng(1)
    positions = np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0]])
    tried: list[float] = []

    def try_out(team: FloatArray) -> float:
        tried.append(height(team))
        return tried[-1]

    chosen = Osarses(20, 0.1, rng).ask(positions, in_box, together, try_out)
    assert len(tried) == 20
    assert height(chosen) == max(tried)
    assert together(chosen[None])[0]
    assert np.allclose(np.linalg.norm(chosen - positions, axis=1), 0.1)


def test_without_trials_osarses_moves_at_random_within_the_constraints() -> None:
    rng = np.random.default_rng(2)
    positions = np.array([[0.99, 0.0, 0.0], [0.8, 0.0, 0.0]])
    for _ in range(50):
        positions = Osarses(0, 0.1, rng).ask(positions, in_box, together, lambda _: pytest.fail("it tried"))
        assert together(positions[None])[0]
        assert len(in_box(0, positions)) == 2


def test_a_team_that_cannot_move_stays() -> None:
    positions = np.array([[0.0, 0.0, 0.0], [0.9, 0.0, 0.0]])
    assert np.array_equal(Osarses(5, 0.1, np.random.default_rng(3)).ask(positions, in_box, together, height), positions)


def test_cao_climbs_what_it_has_measured() -> None:
    rng = np.random.default_rng(4)
    positions = np.array([[0.0, 0.0, -0.9], [0.1, 0.0, -0.9]])
    cao = MappingCao(MappingCaoParams(0.05, candidates=30), 2, rng)
    for _ in range(150):
        cao.tell(positions, height(positions))
        positions = cao.ask(positions, in_box, together)
    assert height(positions) > 0.0


def test_cao_forgets_values_that_no_longer_hold() -> None:
    """What rose with height falls with it when the objective changes: the next step goes down."""
    rng = np.random.default_rng(6)
    positions = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    cao = MappingCao(MappingCaoParams(0.05, candidates=30), 2, rng)
    heights = []
    for _ in range(cao.window + 5):
        cao.tell(positions, height(positions))
        heights.append(height(positions))
        positions = cao.ask(positions, in_box, together)
    cao.tell(positions, height(positions))
    heights.append(height(positions))
    cao.revalue([-each for each in heights[-cao.window :]])
    assert height(cao.ask(positions, in_box, together)) < height(positions)
