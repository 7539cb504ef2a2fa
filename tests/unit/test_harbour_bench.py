"""What `missions bench harbour` tells of its flights."""

from __future__ import annotations

import msgspec
import pytest

from missions.bench.harbour import CASES, Outcome, rows_of, table
from missions.bench.harbour_over_time import RADIOS
from missions.bench.harbour_over_time import Outcome as OverTime
from missions.bench.harbour_over_time import rows_of as over_time_rows
from missions.bench.harbour_over_time import table as over_time_table
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


@pytest.mark.parametrize("name", RADIOS)
def test_every_radio_makes_a_mission_that_flies(name: str) -> None:
    change = RADIOS[name]
    check_task(
        load_named_mission("harbour", lambda mission: msgspec.structs.replace(mission, radio=change(mission.radio)))
    )


def test_maps_on_board_are_told_by_radio_and_time_as_far_as_all_flights_went() -> None:
    rich, poor = list(RADIOS)[:2]
    outcomes = [
        OverTime(rich, (0.8, 0.4), 0.3),
        OverTime(poor, (1.0, 0.6, 0.4), 0.3),
        OverTime(poor, (1.2, 0.8), 0.4),
    ]
    rows = over_time_rows(outcomes)
    told = [(row["radio"], row["minutes"], row["map_error_m"]) for row in rows]
    assert told == [
        (rich, 2, 0.8), (rich, 4, 0.4), (rich, None, 0.3), (poor, 2, 1.1), (poor, 4, 0.7), (poor, None, 0.35)
    ]  # fmt: skip
    assert len(over_time_table(rows).splitlines()) == 3
