"""What `missions bench harbour` tells of its flights."""

from __future__ import annotations

import pytest

from missions.bench.harbour import CASES, Outcome, rows_of, table
from missions.catalogue import load_named_mission
from vehicle_agent.mission.load import check_task


@pytest.mark.parametrize("name", CASES)
def test_every_case_is_a_mission_that_flies(name: str) -> None:
    check_task(load_named_mission("harbour", CASES[name]))


def test_a_row_per_case_that_was_flown() -> None:
    outcomes = [Outcome("as it is", 0.2, 14.0), Outcome("as it is", 0.4, 16.0), Outcome("all stay down", 2.0, 15.0)]
    rows = rows_of(outcomes)
    assert [(row["case"], row["seeds"], row["map_error_m"]) for row in rows] == [
        ("as it is", 2, 0.3),
        ("all stay down", 1, 2.0),
    ]
    assert len(table(rows).splitlines()) == 3
