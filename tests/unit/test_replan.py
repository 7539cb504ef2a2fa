"""The re-planning policy: from two pictures to commands, without a terminal and without a link."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground_station.fleet_state import fold
from ground_station.inputs import AliveChanged, Heard, Tick
from ground_station.picture import FleetState
from ground_station.prediction import predict
from ground_station.replan import ReplanPolicy, convex_hull
from ground_station.station import Station
from tests.fakes.talking_fleet import NAMES, ListLink, Voice, small_plan
from vehicle_agent.domain.polygon import points_inside
from vehicle_agent.mission.load import MissionPlan, plan_mission
from vehicle_agent.mission.model import ReplanTable
from vehicle_agent.mission.tasks import ExploreTask
from vehicle_agent.wire.messages import Orders, Stage, Verb, Zone

POLICY = ReplanPolicy()
SQUARE = ((0, 0), (5_000, 0), (5_000, 5_000))


def plan_of(mode: str = "ask", planner: str = "tours") -> MissionPlan:
    mission = small_plan().mission
    return plan_mission(
        msgspec.structs.replace(
            mission,
            replan=ReplanTable(mode=mode),  # type: ignore[arg-type]
            task=ExploreTask(planner=planner),  # type: ignore[arg-type]
        )
    )


def working(plan: MissionPlan, voices: dict[str, Voice]) -> FleetState:
    """All four at work in the four corners for 100 s, a tenth of the area seen by each of the first two."""
    state = FleetState.initial(plan, "station-0001", 9, 0.0)
    corners = ((2_000, 2_000), (18_000, 2_000), (2_000, 18_000), (18_000, 18_000))
    inputs = [
        Heard(voices["merlin"].delta(range(40), 50.0), 0.0),
        Heard(voices["kestrel"].delta(range(40, 80), 60.0), 0.0),
        *(Heard(voices[name].status(0.0), 0.0) for name in NAMES),
        *(
            Heard(voices[name].status(100.0, position_cm=(*corner, 3_000)), 0.0)
            for name, corner in zip(NAMES, corners, strict=True)
        ),
    ]
    return fold(state, [*inputs, Tick(0.1)])


@pytest.fixture
def voices() -> dict[str, Voice]:
    return {name: Voice(name) for name in NAMES}


def lose(state: FleetState, name: str) -> FleetState:
    return fold(state, [AliveChanged(name, False, state.now_s), Tick(state.now_s + 0.1)])


def test_nothing_is_proposed_while_nothing_changes(voices: dict[str, Voice]) -> None:
    state = working(plan_of(), voices)
    assert POLICY.propose(state, fold(state, [Tick(0.3)])) is None


def test_a_loss_releases_its_goals_at_the_others_and_tells_what_it_costs(voices: dict[str, Voice]) -> None:
    before = working(plan_of(), voices)
    proposal = POLICY.propose(before, lose(before, "merlin"))
    assert proposal is not None
    (step,) = proposal.steps
    assert (step.verb, step.targets, step.payload.subject) == (Verb.RELEASE, NAMES[1:], "merlin")
    assert proposal.cause == "merlin is lost"
    assert proposal.before is not None
    assert proposal.after is not None
    assert proposal.after.remaining_s > proposal.before.remaining_s


def test_a_loss_is_proposed_once(voices: dict[str, Voice]) -> None:
    before = working(plan_of(), voices)
    after = lose(before, "merlin")
    assert POLICY.propose(after, fold(after, [Tick(after.now_s + 0.1)])) is None


def test_planners_that_do_not_share_get_sectors_that_hold_all_unseen_ground(voices: dict[str, Voice]) -> None:
    before = working(plan_of(planner="greedy"), voices)
    proposal = POLICY.propose(before, lose(before, "merlin"))
    assert proposal is not None
    sectors = [step for step in proposal.steps if step.verb is Verb.SECTOR]
    assert [step.targets for step in sectors] == [(name,) for name in NAMES[1:]]
    unseen = before.team_map.area & ~before.team_map.elevation.observed
    points = before.plan.grid.centres_of(np.flatnonzero(unseen.ravel()))
    within = np.zeros(len(points), dtype=bool)
    for step in sectors:
        corners = np.array(step.payload.polygon_cm) / 100
        middle = corners.mean(axis=0)
        within |= points_inside(points, middle + 1.001 * (corners - middle))
        share = points_inside(points, corners).mean()
        assert 0.15 < share < 0.6
    assert within.all()


def test_a_newcomer_gets_only_the_orders_that_it_lacks(voices: dict[str, Voice]) -> None:
    state = working(plan_of(), voices)
    zones = Orders(
        sender="kestrel", boot_id=1, sequence=90, stamp_ms=1, no_fly=(Zone(1, SQUARE), Zone(2, SQUARE[::-1]))
    )
    known = Orders(sender="merlin", boot_id=1, sequence=91, stamp_ms=1, no_fly=(Zone(2, SQUARE[::-1]),))
    state = fold(state, [Heard(zones, 0.1), Heard(known, 0.1), Tick(0.1)])
    away = lose(state, "merlin")
    back = fold(away, [AliveChanged("merlin", True, 1.0), Heard(voices["merlin"].status(101.0), 1.0), Tick(1.0)])
    proposal = POLICY.propose(away, back)
    assert proposal is not None
    (step,) = proposal.steps
    assert (step.verb, step.targets, step.payload.number) == (Verb.NO_FLY, ("merlin",), 1)


def test_one_that_turns_home_early_is_no_reason_for_commands_where_planners_share(voices: dict[str, Voice]) -> None:
    before = working(plan_of(), voices)
    home = fold(before, [Heard(voices["merlin"].status(101.0, Stage.RETURNING), 0.2), Tick(0.2)])
    assert POLICY.propose(before, home) is None
    voices = {name: Voice(name) for name in NAMES}
    before = working(plan_of(planner="greedy"), voices)
    home = fold(before, [Heard(voices["merlin"].status(101.0, Stage.RETURNING), 0.2), Tick(0.2)])
    proposal = POLICY.propose(before, home)
    assert proposal is not None
    assert proposal.cause == "merlin finished early"


def station_after_a_loss(mode: str) -> tuple[Station, ListLink]:
    voices = {name: Voice(name) for name in NAMES}
    station, link = Station(plan_of(mode), "station-0001", 9, 0.0), ListLink()
    station.attach(link)
    link.arriving += [voices[name].status(0.0) for name in NAMES] + [voices["merlin"].delta(range(40), 1.0)]
    link.arriving += [voices[name].status(60.0) for name in NAMES]
    station.step(0.1)
    link.alive_changes.append(("osprey", False))
    station.step(0.2)
    return station, link


def test_a_mission_decides_whether_the_operator_is_asked() -> None:
    station, link = station_after_a_loss("ask")
    assert station.proposal is not None
    assert link.commands() == []
    station.accept(0.3)
    station.accept(0.3)
    assert [command.verb for command in link.commands()] == [Verb.RELEASE]
    station, link = station_after_a_loss("auto")
    assert station.proposal is None
    assert [(command.verb, command.subject) for command in link.commands()] == [(Verb.RELEASE, "osprey")]
    station, link = station_after_a_loss("off")
    assert station.proposal is None
    assert link.commands() == []


def test_a_station_that_comes_back_sends_nothing_for_losses_before_its_time() -> None:
    station, link = Station(plan_of("auto"), "station-0002", 10, 0.0), ListLink()
    station.attach(link)
    link.alive_changes.append(("osprey", False))
    link.arriving += [Voice(name).status(60.0) for name in NAMES if name != "osprey"]
    station.step(0.1)
    station.step(9.0)
    assert link.commands() == []


def test_predictions_need_flown_time_and_somebody_at_work(voices: dict[str, Voice]) -> None:
    state = FleetState.initial(plan_of(), "station-0001", 9, 0.0)
    assert predict(state) is None
    state = working(plan_of(), voices)
    assert predict(state) is not None
    assert predict(state, without=NAMES) is None


@given(st.lists(st.tuples(st.integers(-50, 50), st.integers(-50, 50)), min_size=1, max_size=60))
def test_a_hull_holds_its_points(points: list[tuple[int, int]]) -> None:
    hull = convex_hull(np.array(points, dtype=float))
    assert set(map(tuple, hull)) <= {(float(e), float(n)) for e, n in points}
    if len(hull) < 3:
        return
    for (ae, an), (be, bn) in zip(hull, np.roll(hull, -1, axis=0), strict=True):
        assert all((be - ae) * (n - an) - (bn - an) * (e - ae) >= -1e-9 for e, n in points)
