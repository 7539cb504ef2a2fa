"""The same seed gives the same bytes; another seed another run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import missions
from tests.fakes.hill_missions import copters, hill_plan

FILES = ("summary.json", "events.jsonl", "run.npz")
NOISY = {"loss": 0.2, "delay_s": 0.1}


def saved(folder: Path, seed: int, planner: str) -> dict[str, bytes]:
    stop = {"observed_fraction": 0.99, "time_limit_s": 120.0}
    missions.simulate(hill_plan(seed, planner=planner, stop=stop, radio=NOISY)).save(folder)
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES)
    return {name: (folder / name).read_bytes() for name in FILES}


@pytest.mark.parametrize("planner", ["tours", "lanes", "fcao"])
def test_one_seed_one_result(tmp_path: Path, planner: str) -> None:
    first = saved(tmp_path / "first", 7, planner)
    assert saved(tmp_path / "second", 7, planner) == first
    other = saved(tmp_path / "other", 8, planner)
    assert all(other[name] != first[name] for name in FILES)


def test_files_hold_what_the_result_says(tmp_path: Path) -> None:
    result = missions.simulate(hill_plan(2, stop={"observed_fraction": 0.5}))
    result.save(tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary == json.loads(json.dumps(result.summary()))
    events = [json.loads(line) for line in (tmp_path / "events.jsonl").read_text().splitlines()]
    assert [event["code"] for event in events] == [code for _, _, code, _ in result.events]
    assert [event["time_s"] for event in events] == sorted(event["time_s"] for event in events)
    with np.load(tmp_path / "run.npz") as arrays:
        assert arrays["positions_enu_m"].shape == (len(arrays["times_s"]), 3, 3)
        assert np.array_equal(arrays["elevation_dm"], result.team_map.elevation_dm)


def test_adding_a_vehicle_changes_no_others_dice() -> None:
    """CAO's first step away from home is drawn from the vehicle's own generator alone, with nobody near to wait for."""
    starts = [(60.0, 60.0), (540.0, 540.0)]
    alone = missions.simulate(hill_plan(4, team=copters(starts[:1]), planner="cao", stop={"time_limit_s": 20.0}))
    together = missions.simulate(hill_plan(4, team=copters(starts), planner="cao", stop={"time_limit_s": 20.0}))
    both = min(len(alone.times_s), 30)
    assert np.allclose(alone.positions_enu_m[:both, 0], together.positions_enu_m[:both, 0])


def test_progress_is_told_once_a_second() -> None:
    told: list[tuple[float, float]] = []
    result = missions.simulate(
        hill_plan(1, stop={"time_limit_s": 30.0}), progress=lambda time_s, share: told.append((time_s, share))
    )
    assert [time_s for time_s, _ in told] == result.times_s.tolist()
    assert np.diff(result.times_s).min() >= 0.99
