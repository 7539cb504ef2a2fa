"""The mapping bench: every method keeps the same constraints, maps agree after repair, rows have the agreed keys."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

from missions.bench.cli import bench
from missions.bench.mapping import KEYS, ROBUST, Outcome, cases_of, disturbance, rows_of, times_by_done
from missions.bench.mapping_methods import ABLATION, METHODS, exchange_for, make_mover
from missions.bench.mapping_run import MappingRun, Team, Trouble, run_team
from missions.bench.mapping_world import MAPS, Setup, World, make_world

SETUP = Setup(steps=12)


def run(world: World, method: str, vehicles: int, trouble: Trouble | None = None, seed: int = 5) -> MappingRun:
    sensing, dice = (np.random.default_rng([seed, purpose]) for purpose in (0, 1))
    team = Team(world, SETUP, vehicles, exchange_for(method, SETUP, world), trouble or Trouble(), sensing)
    return run_team(team, make_mover(method, vehicles, len(world.layout), SETUP, dice), SETUP.steps)


@pytest.mark.parametrize("method", [*METHODS, next(iter(ABLATION))])
def test_every_method_keeps_the_same_constraints(method: str) -> None:
    world = make_world("rugged", few=True)
    positions = run(world, method, 3).positions
    assert positions.shape == (SETUP.steps + 1, 3, 3)
    assert np.linalg.norm(np.diff(positions, axis=0), axis=2).max() <= SETUP.reach_m * (1 + 1e-6)
    for team in positions:
        assert np.abs(team[:, :2]).max() <= 1.0
        assert np.all(team[:, 2] >= world.heights_at(team[:, :2]) + SETUP.clearance_m - 1e-6)
        assert team[:, 2].max() <= SETUP.ceiling_m
        away = np.linalg.norm(team[:, None] - team[None], axis=2) + np.where(np.eye(3) > 0, np.inf, 0.0)
        assert np.all(away.min(axis=1) <= SETUP.radio_range_m * (1 + 1e-6))


def test_survivors_of_loss_and_death_agree_after_repair() -> None:
    trouble = Trouble(loss=0.3, dead_vehicle=1, dead_at=6)
    result = run(make_world("ridge", few=True), "default", 4, trouble)
    assert result.agree_after_repair
    assert np.all(np.diff(result.positions[6:, 1], axis=0) == 0.0)
    assert np.any(np.diff(result.positions[7:, 0], axis=0) != 0.0)


def test_the_same_seed_gives_the_same_run() -> None:
    world = make_world("ridge", few=True)
    first, second = (run(world, "osarses-5", 3) for _ in range(2))
    assert np.array_equal(first.positions, second.positions)
    assert np.array_equal(first.remaining_percent, second.remaining_percent)
    assert first.remaining_percent[-1] < first.remaining_percent[0] < 100.0


def test_a_vehicle_that_starts_alone_may_move() -> None:
    world = make_world("ridge", few=True)
    team = Team(world, SETUP, 2, exchange_for("default", SETUP, world), Trouble(), np.random.default_rng(1))
    team.positions[1] = (0.9, 0.9, 0.9)
    result = run_team(team, make_mover("default", 2, len(world.layout), SETUP, np.random.default_rng(2)), SETUP.steps)
    assert np.all(np.any(result.positions[-1] != result.positions[0], axis=1))


@pytest.mark.parametrize("name", MAPS)
def test_maps_fill_the_cube_and_have_the_papers_landmarks(name: str) -> None:
    few, every = make_world(name, few=True), make_world(name, few=False)
    assert len(few.layout) == 1_100
    assert len(every.layout) == every.elevation.size
    for world in (few, every):
        assert np.abs(world.heights).max() <= 1.0
        assert np.abs(world.layout.positions_en_m).max() < 1.0


def test_rows_have_exactly_the_agreed_keys() -> None:
    cases = list(cases_of(2, (3,), ("1100",), 7, None))
    assert {case.method for case in cases} == {*METHODS, ROBUST, *ABLATION}
    outcomes = [(case, Outcome(float(case.seed), 10.0, 40.0, (0.5,), True)) for case in cases]
    rows = rows_of(outcomes)
    assert all(tuple(row) == KEYS for row in rows)
    assert [row["remaining_percent_mean"] for row in rows] == [7.5] * len(rows)
    assert len(rows) == 2 * (len(METHODS) + 1 + len(ABLATION))


def test_what_trouble_costs_and_what_a_decision_takes_are_told() -> None:
    cases = [case for case in cases_of(2, (3,), ("1100",), 7, None) if case.map == "ridge"]
    left = {"default": 0.4, ROBUST: 0.5}
    done = (0.0, 5.0, 55.0, 99.9)
    outcomes = [
        (case, Outcome(left.get(case.method, 9.0), 1.0, 4.0, (1.0, 3.0, 4.0, 5.0), case.seed == 7, done))
        for case in cases
    ]
    assert "leave 0.500 % instead of 0.400 %" in disturbance(outcomes)
    assert "in 1 of 2 runs" in disturbance(outcomes)
    assert times_by_done(outcomes).endswith("2.00  -  -  -  -  4.00  -  -  -  5.00")


def test_what_a_vehicle_hears_is_what_arrives() -> None:
    world = make_world("ridge", few=True)
    for loss, heard in ((0.0, 6), (1.0, 0)):
        team = Team(world, SETUP, 3, exchange_for("default", SETUP, world), Trouble(loss), np.random.default_rng(1))
        team.sense_and_tell()
        assert team.heard.sum() == heard


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--landmarks", "1000"], "is not 1100, all or both"),
        (["--vehicles", "1"], "at least 2 vehicles"),
        (["--vehicles", "x"], "is not like 5,8,12"),
        (["--seeds", "0"], "is not in the range"),
    ],
)
def test_wrong_options_get_a_sentence(arguments: list[str], sentence: str) -> None:
    result = CliRunner().invoke(bench, ["mapping", *arguments])
    assert result.exit_code == 2
    assert sentence in result.output
