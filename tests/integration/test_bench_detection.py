"""The bench of losses with real processes: every loss is shown with a proposal, and an outage is no loss."""

from __future__ import annotations

import pytest

from missions.bench.detection import Figures, detect, missed


@pytest.mark.processes
def test_deaths_and_cuts_are_shown_and_short_outages_are_not() -> None:
    figures = detect(vehicles=2, kills=1, cuts=1, outages=1)
    assert figures.unseen == []
    assert [len(values) for values in (figures.killed_s, figures.proposal_s, figures.cut_s)] == [1, 1, 1]
    assert figures.outages == 2


def test_a_missed_bar_is_named() -> None:
    slow = Figures(20, killed_s=[0.1, 0.9], cut_s=[3.0], proposal_s=[0.2], false_losses=1)
    assert [text.split(":")[0] for text in missed(slow)] == ["killed to lost, p99", "1 false losses in outages of 2 s"]
    assert missed(Figures(20, killed_s=[0.1], cut_s=[3.4], proposal_s=[1.9])) == []
