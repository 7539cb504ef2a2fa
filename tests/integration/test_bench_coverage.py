"""`missions bench coverage`: its rows, and exports from which anybody can recompute them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from missions.bench.coverage import DEFAULT, OPTIMUM, PLANNERS
from missions.bench.coverage_starts import STARTS
from missions.cli import main
from tests.fakes.waiting import until
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.sensing import visible_surface

REPOSITORY = Path(__file__).parents[2]
KEYS = {
    "vehicles", "start", "planner", "default", "initial_mean", "initial_sd", "final_mean", "final_sd", "best_mean",
    "best_sd", "of_optimum", "step_ms_median",
}  # fmt: skip


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Path]:
    folder = tmp_path_factory.mktemp("bench")
    arguments = ["bench", "coverage", "--environments", "1", "--vehicles", "2,3", "--seed", "4"]
    files = ["--json", str(folder / "rows.json"), "--export", str(folder / "runs")]
    run = subprocess.run(
        [sys.executable, "-m", "missions.cli", *arguments, *files],
        cwd=REPOSITORY, capture_output=True, text=True, timeout=250.0, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    return json.loads((folder / "rows.json").read_text()), folder / "runs"


def test_every_start_and_planner_has_its_row(measured: tuple[dict[str, Any], Path]) -> None:
    content, _ = measured
    assert set(content) == {"bench", "seed", "rows"}
    assert (content["bench"], content["seed"]) == ("coverage", 4)
    assert all(set(row) == KEYS for row in content["rows"])
    found = [(row["vehicles"], row["start"], row["planner"]) for row in content["rows"]]
    rivals = [(start, planner) for start in STARTS for planner in PLANNERS]
    assert found == [(size, *one) for size in (2, 3) for one in [("any", OPTIMUM), *rivals]]
    assert [row["planner"] for row in content["rows"] if row["default"]] == [DEFAULT] * 2 * len(STARTS)
    for row in content["rows"]:
        assert row["best_mean"] >= row["final_mean"] - 1e-12
        assert row["best_mean"] >= row["initial_mean"] - 1e-12
        assert row["of_optimum"] > 0.0


def test_coverage_can_be_recomputed_from_the_export(measured: tuple[dict[str, Any], Path]) -> None:
    content, folder = measured
    ground = np.load(folder / "env_000.npz")
    elevation_m, cell_m = ground["elevation_m"], float(ground["cell_m"])
    grid = Grid(0.0, 0.0, cell_m, *elevation_m.shape)
    for row in content["rows"]:
        run = np.load(folder / f"run_000_{row['planner']}-{row['start']}-{row['vehicles']}.npz")
        track = run["positions_enu_m"]
        assert track.shape[1:] == (row["vehicles"], 3)
        for places, share in ((track[0], row["initial_mean"]), (track[-1], row["final_mean"])):
            seen = [visible_surface(grid, elevation_m, tuple(place), float(run["range_m"])) for place in places]
            assert len(np.unique(np.concatenate(seen))) / elevation_m.size == pytest.approx(share)


@pytest.mark.parametrize("sizes", ["0", "65", "5,,8", "5,-3", "x"])
def test_team_sizes_that_cannot_be_are_refused(sizes: str) -> None:
    result = CliRunner().invoke(main, ["bench", "coverage", "--vehicles", sizes])
    assert result.exit_code == 2
    assert "is not like 5,8,12" in result.output


def test_an_export_folder_that_cannot_be_written_is_told_in_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    result = CliRunner().invoke(main, ["bench", "coverage", "--export", str(tmp_path / "file")])
    assert result.exit_code == 2


@pytest.mark.processes
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_who_stops_a_bench_keeps_what_is_done(tmp_path: Path, how: signal.Signals) -> None:
    rows, runs = tmp_path / "rows.json", tmp_path / "runs"
    bench = subprocess.Popen(
        [sys.executable, "-m", "missions.cli", "bench", "coverage", "--environments", "200", "--vehicles", "1",
         "--json", str(rows), "--export", str(runs)],
        cwd=REPOSITORY, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    try:
        cores = os.cpu_count() or 1

        def one_result_came() -> bool:
            assert bench.poll() is None
            return len(list(runs.glob("run_*_stations-corner-1.npz"))) > cores

        until(one_result_came, "a result", within_s=200.0)
        workers = Path(f"/proc/{bench.pid}/task/{bench.pid}/children").read_text().split()
        bench.send_signal(how)
        bench.communicate(timeout=60.0)
    finally:
        bench.kill()  # whatever failed: nothing of it may go on using the cores
    assert bench.returncode == 130
    assert json.loads(rows.read_text())["rows"]
    until(lambda: not any(os.path.exists(f"/proc/{worker}") for worker in workers), "the bench's workers to end")
