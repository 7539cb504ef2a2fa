"""What a vehicle believes of its teammates: heard, lost, back, their claims and the legs to keep clear of."""

from __future__ import annotations

import pytest

from vehicle_agent.behaviour.team_picture import HAZARD_S, TeamPicture
from vehicle_agent.planning.constraints import Reservation
from vehicle_agent.wire.messages import Claim, Stage, Status

TEAM = ("ada", "bob", "cyd")
SILENCE_S = 15.0


def status(
    sender: str = "bob",
    sequence: int = 0,
    boot_id: int = 1,
    stage: Stage = Stage.WORKING,
    armed: bool = True,
    mode: str = "guided",
    leg_end_cm: tuple[int, int, int] = (20_000, 0, 6_000),
) -> Status:
    return Status(
        sender=sender,
        boot_id=boot_id,
        sequence=sequence,
        stamp_ms=0,
        stage=stage,
        mode=mode,
        armed=armed,
        position_cm=(10_000, 0, 6_000),
        velocity_cm_s=(0, 0, 0),
        heading_deg=0,
        battery_permille=900,
        leg_end_cm=leg_end_cm,
        home_cm=(0, 0, 500),
        known_permille=0,
        first_seen_cells=0,
        bytes_sent=0,
        messages_dropped=0,
        why="",
        return_up_cm=9_000,
    )


def claim(
    sender: str = "bob", sequence: int = 1, boot_id: int = 1, active: bool = True, east_cm: int = 30_000
) -> Claim:
    goal = (east_cm, 0, 6_000)
    return Claim(sender=sender, boot_id=boot_id, sequence=sequence, stamp_ms=0, active=active, goal_cm=goal, cost_m=200)


@pytest.fixture
def picture() -> TeamPicture:
    return TeamPicture("ada", TEAM, SILENCE_S)


def test_nobody_is_heard_at_first(picture: TeamPicture) -> None:
    assert picture.living() == []
    assert picture.teammates() == ()
    assert picture.reservations(1e9) == ()
    assert picture.newly_lost(1e9) == []


def test_strangers_and_oneself_are_no_teammates(picture: TeamPicture) -> None:
    picture.hear_status(status("ada"), 0.0)
    picture.hear_status(status("eve"), 0.0)
    picture.hear_claim(claim("eve"))
    assert picture.living() == []


def test_a_teammate_is_lost_once_and_comes_back_once(picture: TeamPicture) -> None:
    assert not picture.hear_status(status(), 0.0)
    assert picture.newly_lost(SILENCE_S) == []
    assert picture.newly_lost(SILENCE_S + 0.1) == ["bob"]
    assert picture.newly_lost(SILENCE_S + 5.0) == []
    assert picture.living() == []
    assert picture.hear_status(status(sequence=1), 40.0)
    assert not picture.hear_status(status(sequence=2), 41.0)
    assert picture.living() == ["bob"]


def test_an_old_status_is_no_sign_of_life(picture: TeamPicture) -> None:
    picture.hear_status(status(sequence=5), 0.0)
    picture.hear_status(status(sequence=5), 14.0)
    picture.hear_status(status(sequence=4), 14.0)
    assert picture.newly_lost(SILENCE_S + 0.1) == ["bob"]


def test_a_restarted_teammate_counts_from_anew(picture: TeamPicture) -> None:
    picture.hear_status(status(sequence=500, boot_id=1), 0.0)
    picture.hear_status(status(sequence=0, boot_id=2), 10.0)
    assert picture.newly_lost(20.0) == []


def test_a_claim_holds_until_it_is_let_go(picture: TeamPicture) -> None:
    picture.hear_status(status(), 0.0)
    assert picture.teammates()[0].goal_enu_m is None
    picture.hear_claim(claim(sequence=3))
    (bob,) = picture.teammates()
    assert bob.goal_enu_m == pytest.approx((300.0, 0.0, 60.0))
    assert bob.goal_cost_m == 200.0
    picture.hear_claim(claim(sequence=2, east_cm=99_900))
    assert picture.teammates() == (bob,)
    picture.hear_claim(claim(sequence=4, active=False))
    assert picture.teammates()[0].goal_enu_m is None


def test_a_lost_teammate_frees_its_claim(picture: TeamPicture) -> None:
    picture.hear_status(status(), 0.0)
    picture.hear_claim(claim())
    picture.newly_lost(100.0)
    assert picture.teammates() == ()


@pytest.mark.parametrize("stage", [Stage.RETURNING, Stage.LANDING, Stage.DONE, Stage.YIELDED, Stage.ARMING])
def test_who_does_not_work_takes_no_share_but_keeps_its_place(picture: TeamPicture, stage: Stage) -> None:
    picture.hear_status(status(stage=stage), 0.0)
    assert picture.teammates() == ()
    assert len(picture.reservations(0.0)) >= 1


def test_the_living_reserve_the_leg_they_tell(picture: TeamPicture) -> None:
    picture.hear_status(status(), 0.0)
    assert picture.reservations(1.0) == (Reservation((100.0, 0.0, 60.0), (200.0, 0.0, 60.0), 1),)


def test_the_way_home_of_the_silent_is_kept_clear_for_a_while(picture: TeamPicture) -> None:
    picture.hear_status(status(), 0.0)
    picture.newly_lost(20.0)
    way = picture.reservations(20.0)
    assert all(leg.has_way for leg in way)
    places = [(leg.start_enu_m, leg.end_enu_m) for leg in way]
    assert ((100.0, 0.0, 60.0), (200.0, 0.0, 60.0)) in places
    assert ((200.0, 0.0, 90.0), (0.0, 0.0, 90.0)) in places
    assert ((0.0, 0.0, 90.0), (0.0, 0.0, 5.0)) in places
    assert picture.reservations(HAZARD_S + 1.0) == ()


def test_a_silent_vehicle_on_the_ground_is_in_nobodys_way(picture: TeamPicture) -> None:
    picture.hear_status(status(armed=False, stage=Stage.DONE), 0.0)
    picture.newly_lost(20.0)
    assert picture.reservations(20.0) == ()


def test_a_failsafes_way_home_is_kept_clear_while_its_agent_talks(picture: TeamPicture) -> None:
    picture.hear_status(status(stage=Stage.YIELDED, mode="return"), 0.0)
    ends = [leg.end_enu_m for leg in picture.reservations(1.0)]
    assert (0.0, 0.0, 90.0) in ends
    assert (0.0, 0.0, 5.0) in ends


def test_who_rests_disarmed_is_in_nobodys_way(picture: TeamPicture) -> None:
    picture.hear_status(status(stage=Stage.DONE, armed=False), 0.0)
    assert picture.reservations(1.0) == ()


@pytest.mark.parametrize("stage", [Stage.TAKING_OFF, Stage.LANDING])
def test_who_cannot_stop_has_the_way_over_all(picture: TeamPicture, stage: Stage) -> None:
    picture.hear_status(status(stage=stage), 0.0)
    (leg,) = picture.reservations(1.0)
    assert leg.precedes(0)
    assert picture.passages(1.0) == (leg,)


def test_a_way_home_goes_on_from_over_home_to_the_ground(picture: TeamPicture) -> None:
    picture.hear_status(status(stage=Stage.RETURNING), 0.0)
    assert picture.reservations(1.0) == (Reservation((100.0, 0.0, 60.0), (200.0, 0.0, 60.0), 1),)
    assert picture.passages(1.0) == (Reservation((0.0, 0.0, 60.0), (0.0, 0.0, 5.0), 1),)
    picture.hear_status(status(sequence=1, stage=Stage.RETURNING, leg_end_cm=(300, 0, 6_000)), 1.0)
    assert Reservation((3.0, 0.0, 60.0), (0.0, 0.0, 5.0), 1) in picture.reservations(1.0)


def test_nobody_who_works_rests_over_one_who_sets_out_but_others_may_pass(picture: TeamPicture) -> None:
    picture.hear_status(status(stage=Stage.ARMING), 0.0)
    assert picture.reservations(1.0) == (Reservation((100.0, 0.0, 60.0), (100.0, 0.0, 60.0), 1),)
    assert picture.passages(1.0) == (Reservation((100.0, 0.0, 60.0), (200.0, 0.0, 60.0), 1),)
