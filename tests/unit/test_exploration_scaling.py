"""The bench of planning time by size of team and map, with tiny sizes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from missions.bench.exploration_scaling import SIZES, Size, bench_scaling
from missions.cli import main
from vehicle_agent.mission.tasks import DEFAULT_PLANNER


def test_rows_tell_planning_time_of_both_sides_for_every_size(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "rows.json"
    assert bench_scaling(1, 8.0, 2.0, 3, file, [Size(1, 40), Size(3, 50)], steps=4) == 0
    told = json.loads(file.read_text())
    assert told["bench"] == "exploration-scaling"
    asked = [(row["planner"], row["vehicles"], row["cells_per_side"], row["decisions"]) for row in told["rows"]]
    sides = (DEFAULT_PLANNER, "closest-frontier")
    assert asked == [(side, n, cells, 4 * n) for n, cells in ((1, 40), (3, 50)) for side in sides]
    for row in told["rows"]:
        assert 0.0 < row["plan_ms_median"] <= row["plan_ms_p99"]
        assert row["plan_ms_mean"] > 0.0
        assert row["default"] == (row["planner"] == DEFAULT_PLANNER)
    assert len(capsys.readouterr().out.splitlines()) == 2 + 4


def test_larger_maps_have_as_many_hills_to_the_hectare() -> None:
    for size in SIZES:
        assert size.hills.grid.shape == (size.cells_per_side, size.cells_per_side)
        assert size.hills.peaks * 100**2 == 8 * size.cells_per_side**2


def test_options_that_scaling_would_ignore_are_refused() -> None:
    result = CliRunner().invoke(main, ["bench", "exploration", "--scaling", "--vehicles", "4"])
    assert result.exit_code == 2
    assert "--vehicles" in result.output
