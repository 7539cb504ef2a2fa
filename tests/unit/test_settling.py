"""When a team has settled: in periods, however quickly each vehicle decides."""

from __future__ import annotations

import pytest

from vehicle_agent.planning.interface import Teammate
from vehicle_agent.planning.settling import Settling, SettlingParams

PARAMS = SettlingParams(heated_decisions=0, patience=4, hold=8)
HERE, THERE = (0.0, 0.0, 5.0), (20.0, 0.0, 5.0)
MATE = Teammate(1, THERE, THERE)


def periods_until_done(settling: Settling, periods: int, moves_at: int | None = None) -> int:
    """Decide every so many periods beside a teammate that stays, or moves once."""
    passed = 0
    while not settling.is_done:
        assert passed < 100
        passed += periods
        mate = MATE if moves_at is None or passed < moves_at else Teammate(1, HERE, HERE)
        settling.count(0, HERE, HERE, (mate,), 1.0, periods)
    return passed


@pytest.mark.parametrize("periods", [1, 2, 3])
def test_who_decides_seldom_ends_with_the_others(periods: int) -> None:
    quick = periods_until_done(Settling(PARAMS), 1)
    assert quick == PARAMS.patience + PARAMS.hold + 1  # what it sees first is no rest yet
    assert abs(periods_until_done(Settling(PARAMS), periods) - quick) <= periods


def test_a_move_begins_the_count_anew() -> None:
    assert periods_until_done(Settling(PARAMS), 2, moves_at=6) >= 6 + PARAMS.patience + PARAMS.hold
