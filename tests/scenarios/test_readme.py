"""What the README promises to run, runs."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import get_args

from missions.catalogue import load_named_mission
from vehicle_agent.mission.tasks import CoverPlannerName, MapPlannerName, PlannerName

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_python_script_runs_and_reports_a_whole_map():
    script = re.search(r"<!-- script -->\n```python\n(.*?)```", README, re.DOTALL)
    assert script is not None
    run = subprocess.run([sys.executable, "-c", script[1]], cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    share = re.match(r"([\d.]+) % of the reachable surface in (\d+) s", run.stdout)
    assert share is not None
    assert float(share[1]) >= 99.0
    assert run.stdout.count("cells first") == 4


def test_every_planner_of_the_table_is_one_that_a_mission_may_name():
    table = README.split("## How a vehicle decides")[1].split("\n\n**")[0]
    named = set(re.findall(r"`([a-z-]+)`", " ".join(re.findall(r"^\| (`.*?) \|", table, re.MULTILINE))))
    assert named == {*get_args(PlannerName), *get_args(CoverPlannerName), *get_args(MapPlannerName)}


def test_the_mission_shown_is_the_ridge():
    shown = README.split("```toml")[1].split("```")[0]
    ridge = load_named_mission("ridge").source.read_text(encoding="utf-8")
    keys = {line.split("#")[0].strip() for line in shown.splitlines() if "=" in line and not line.startswith("#")}
    assert keys <= {line.split("#")[0].strip() for line in ridge.splitlines()}
