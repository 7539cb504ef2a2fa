"""Lanes: what they are expected to show, and that a team's ways get shorter without leaving ground out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.domain.expected_ground import ExpectedGround
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.lane_sight import look_around, sight_of, sweep
from vehicle_agent.domain.lane_trials import Ways
from vehicle_agent.domain.shared_lanes import LaneCosts, annealing_of, mend_lanes

SHAPE = (20, 16)
COSTS = LaneCosts(0.0, 0.6, 4.0, 1.0, 0.0)
PARTS = st.floats(-3.0, 22.0)


def left_by(ways: Ways) -> float:
    """What is expected to stay unseen of a wholly unseen ground."""
    unseen, summed = np.ones(SHAPE), np.zeros(SHAPE, dtype=np.int32)
    left = unseen.sum()
    for bends, count in zip(ways.bends, ways.counts, strict=True):
        for place in range(1, count):
            left += sweep(sight_of(4.0, 1.5, SHAPE), unseen, summed, *bends[place - 1], *bends[place], 1)
    return float(left)


def ways_from(starts: FloatArray) -> Ways:
    bends = np.zeros((len(starts), 24, 2))
    bends[:, 0] = starts
    return Ways(bends, np.ones(len(starts), dtype=np.int64), starts.copy())


def mended(ways: Ways, seed: int, costs: LaneCosts = COSTS, trials: int = 20_000, at_once: int = 20_000) -> FloatArray:
    """Mend ways over wholly unseen ground; their lengths, (N,) float64, the weighed way home included."""
    rng = np.random.default_rng(seed)
    annealing = annealing_of(ways, trials, 0.5, 0.01)
    while not mend_lanes(ways, annealing, sight_of(4.0, 1.5, SHAPE), np.ones(SHAPE), costs, at_once, rng):
        pass
    lengths = [
        np.hypot(*np.diff(bends[:count], axis=0).T).sum() + costs.way_back * np.hypot(*(bends[count - 1] - home))
        for bends, count, home in zip(ways.bends, ways.counts, ways.homes, strict=True)
    ]
    return np.array(lengths)


@settings(deadline=None)
@given(PARTS, PARTS, PARTS, PARTS, PARTS, PARTS)
def test_a_lane_taken_off_leaves_what_was_before(
    a_u: float, a_v: float, b_u: float, b_v: float, c_u: float, c_v: float
) -> None:
    sight, unseen, summed = sight_of(3.0, 1.0, SHAPE), np.ones(SHAPE), np.zeros(SHAPE, dtype=np.int32)
    first = sweep(sight, unseen, summed, a_u, a_v, b_u, b_v, 1)
    before = summed.copy()
    more = sweep(sight, unseen, summed, b_u, b_v, c_u, c_v, 1)
    assert -unseen.sum() <= first + more <= first <= 0.0
    assert sweep(sight, unseen, summed, b_u, b_v, c_u, c_v, -1) == pytest.approx(-more)
    assert np.array_equal(summed, before)


def test_ground_is_the_surer_seen_the_nearer_it_lies_to_a_lane() -> None:
    sight, unseen, summed = sight_of(4.0, 1.5, SHAPE), np.ones(SHAPE), np.zeros(SHAPE, dtype=np.int32)
    sweep(sight, unseen, summed, 2.0, 8.0, 17.0, 8.0, 1)
    across = summed[10, 8:]
    assert (np.diff(across) <= 0).all()
    assert across[0] > across[3] > 0
    assert across[5:].max() == 0
    assert np.array_equal(summed[:, 8 - 4], summed[:, 8 + 4])


def test_what_a_look_did_not_show_only_a_nearer_one_shows() -> None:
    sight, unseen, summed = sight_of(4.0, 1.5, SHAPE), np.ones(SHAPE), np.zeros(SHAPE, dtype=np.int32)
    look_around(sight, np.array([[10.0, 8.0]]), 1_000)
    sweep(sight, unseen, summed, 10.0, 11.0, 10.0, 11.1, 1)
    assert summed[10, 11] > 0
    assert summed[10, 9] == 0


def test_what_a_sure_look_did_not_show_only_one_from_near_may_show() -> None:
    sight = sight_of(8.0, 1.0, SHAPE).over(known(np.zeros(SHAPE)), np.zeros(SHAPE, dtype=np.int32))
    look_around(sight, np.array([[4.0, 8.0]]), int(0.9 * sight.odds.max()))
    a_little, near = np.zeros(SHAPE, dtype=np.int32), np.zeros(SHAPE, dtype=np.int32)
    sweep(sight, np.ones(SHAPE), a_little, 4.1, 8.0, 4.1, 8.1, 1)
    sweep(sight, np.ones(SHAPE), near, 9.0, 8.0, 9.0, 8.1, 1)
    assert a_little[10, 8] == 0 < near[10, 8]
    assert a_little[12, 8] > 0


@pytest.mark.parametrize("seed", range(3))
def test_two_vehicles_share_the_ground_and_see_all_of_it(seed: int) -> None:
    starts = np.array([[0.0, 0.0], [0.0, 1.0]])
    both, alone = ways_from(starts), ways_from(starts[:1])
    lengths, length = mended(both, seed), mended(alone, seed)
    assert left_by(both) < 0.03 * SHAPE[0] * SHAPE[1]
    assert left_by(alone) < 0.03 * SHAPE[0] * SHAPE[1]
    assert lengths.max() < 0.75 * length.max()
    assert np.array_equal(both.bends[:, 0], starts)


def test_mending_makes_nothing_worse_and_repeats() -> None:
    first, second = (ways_from(np.array([[0.0, 0.0], [19.0, 15.0]])) for _ in range(2))
    assert np.array_equal(mended(first, 4), mended(second, 4))
    assert np.array_equal(first.bends, second.bends)
    before = mended(first, 5, trials=0).max(), left_by(first)
    after = mended(first, 6, trials=500).max(), left_by(first)
    worth = [
        longest + COSTS.unseen * (left + COSTS.dearer * max(0.0, left - COSTS.allowed))
        for longest, left in (before, after)
    ]
    assert worth[1] <= worth[0] + 1.0


def test_a_way_home_is_part_of_a_way() -> None:
    there, back = ways_from(np.array([[0.0, 0.0]])), ways_from(np.array([[0.0, 0.0]]))
    one_way = mended(there, 1)
    both_ways = mended(back, 1, COSTS._replace(way_back=1.0))
    end = back.bends[0, back.counts[0] - 1]
    assert both_ways[0] > one_way[0]
    assert np.hypot(*end) < np.hypot(*there.bends[0, there.counts[0] - 1])


def test_many_vehicles_from_one_place_leave_no_chance_of_missing_what_they_all_pass() -> None:
    starts = np.full((60, 2), 9.0)
    crowd = ways_from(starts)
    crowd.bends[:, 1] = (12.0, 9.0)
    crowd.counts[:] = 2
    mended(crowd, 1, trials=2_000)
    assert left_by(crowd) < left_by(ways_from(starts))
    sight, summed = sight_of(4.0, 1.5, SHAPE), np.zeros(SHAPE, dtype=np.int32)
    for _ in range(60):
        sweep(sight, np.ones(SHAPE), summed, 9.0, 9.0, 12.0, 9.0, 1)
    assert summed.max() > len(sight.missed)
    assert -0.05 < sweep(sight, np.ones(SHAPE), summed, 9.0, 9.0, 12.0, 9.0, 1) <= 0.0


def test_mended_in_parts_ways_become_what_they_do_at_once() -> None:
    starts = np.array([[1.0, 1.0], [2.0, 1.0]])
    at_once, in_parts = (mended(ways_from(starts), 5, at_once=part) for part in (20_000, 3_000))
    assert in_parts == pytest.approx(at_once, rel=1e-6)


def test_what_is_nearly_all_seen_is_led_to() -> None:
    unseen = np.zeros((200, 200))
    unseen[150, 40] = 5.0
    ways = ways_from(np.array([[10.0, 10.0]]))
    costs = LaneCosts(0.0, 40.0, 4.0, 0.0, 0.0)
    annealing = annealing_of(ways, 500, 0.5, 0.01)
    mend_lanes(ways, annealing, sight_of(4.0, 1.5, (200, 200)), unseen, costs, 500, np.random.default_rng(3))
    bends = ways.bends[0, 1 : ways.counts[0]]
    assert np.hypot(*(bends - (150.0, 40.0)).T).min() < 4.0


def known(heights: FloatArray) -> ExpectedGround:
    """Ground of which all is known."""
    return ExpectedGround(heights, np.zeros(heights.shape), 0.0, 1.0)


@pytest.mark.parametrize("seed", range(3))
def test_a_way_leads_round_a_hill(seed: int) -> None:
    level, hill, unseen = np.zeros(SHAPE), np.zeros(SHAPE), np.zeros(SHAPE)
    hill[6:13, :11] = 12.0
    unseen[18, 7] = 40.0
    northings = []
    for heights in (level, hill):
        ways = ways_from(np.array([[1.0, 7.0]]))
        sight = sight_of(4.0, 1.5, SHAPE).over(known(heights), np.zeros(SHAPE, dtype=np.int32))
        annealing = annealing_of(ways, 20_000, 0.5, 0.01)
        mend_lanes(ways, annealing, sight, unseen, COSTS, 20_000, np.random.default_rng(seed))
        bends = ways.bends[0, : ways.counts[0]]
        northings.append(np.interp(9.5, bends[:, 0], bends[:, 1]))
    assert northings[0] < 9.0
    assert northings[1] > 10.0


def test_up_a_slope_a_lane_shows_a_wider_strip_than_down() -> None:
    slope = np.broadcast_to(np.arange(float(SHAPE[1])), SHAPE).copy()
    sight, summed = (
        sight_of(4.0, 1.5, SHAPE).over(known(slope), np.zeros(SHAPE, dtype=np.int32)),
        np.zeros(SHAPE, dtype=np.int32),
    )
    sweep(sight, np.ones(SHAPE), summed, 2.0, 8.0, 17.0, 8.0, 1)
    up, down = np.count_nonzero(summed[10, 9:]), np.count_nonzero(summed[10, :8])
    assert up > down > 0


def test_what_is_unknown_is_seen_less_surely_than_known_ground_as_level() -> None:
    unknown, summed = sight_of(4.0, 1.5, SHAPE), np.zeros((2, *SHAPE), dtype=np.int32)
    level = unknown.over(known(np.zeros(SHAPE)), np.zeros(SHAPE, dtype=np.int32))
    for sight, sums in zip((unknown, level), summed, strict=True):
        sweep(sight, np.ones(SHAPE), sums, 2.0, 8.0, 17.0, 8.0, 1)
    assert (summed[0] <= summed[1]).all()
    assert summed[0, 10, 11] < summed[1, 10, 11]
