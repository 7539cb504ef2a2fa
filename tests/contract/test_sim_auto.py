"""Automatic flight: missions are flown, told of, paused, jumped in and ended as ArduCopter does."""

from __future__ import annotations

import math
from typing import Any

import pytest

from sim_bridge.autopilot.dialect import mavlink
from sim_bridge.flight_plan import PlanItem
from sim_bridge.modes import LandedState
from tests.fakes.sim_client import Bench, kinds, result

AUTO, GUIDED, LOITER = 3, 4, 5
NONE = (0.0, 0.0, 0.0, 0.0)


class Flight(Bench):
    """A bench with a mission on board."""

    def place(self, east_m: float, north_m: float) -> tuple[int, int]:
        place = self.node.datum.to_geodetic((east_m, north_m, 0.0))
        return (round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7))

    def item(
        self, command: int, *parameters: float, at: tuple[float, float] | None = None, up: float = 0.0
    ) -> PlanItem:
        padded = (*parameters, *NONE)[:4]
        x, y = self.place(*at) if at else (0, 0)
        return PlanItem(command, 3, padded, x, y, up)  # type: ignore[arg-type]

    def load(self, *items: PlanItem) -> None:
        self.vehicle.flight_plan.mission = (self.item(16), *items)
        self.vehicle.auto_flight.mission_replaced()

    @property
    def vehicle(self) -> Any:
        return self.fleet.vehicles[0]

    def arm(self) -> None:
        self.wait(6.0)
        assert self.vehicle.arm().accepted

    def start(self) -> None:
        assert result(self.asker.command(300), 300) == 0

    def wait_until(self, condition: Any, most_s: float = 200.0) -> None:
        for _ in range(round(most_s / 0.5)):
            if condition():
                return
            self.wait(0.5)
        raise AssertionError("it did not happen")

    def reached(self) -> list[int]:
        return [m.seq for m in self.asker.heard() if m.get_type() == "MISSION_ITEM_REACHED"]


@pytest.fixture
def flight() -> Flight:
    return Flight()


def test_a_whole_mission_from_the_ground_to_the_ground(flight: Flight) -> None:
    flight.load(
        flight.item(22, up=25.0),
        flight.item(16, 3.0, at=(260.0, 200.0), up=30.0),
        flight.item(178, 1.0, 4.0),
        flight.item(16, at=(260.0, 300.0), up=40.0),
        flight.item(21),
    )
    flight.arm()
    flight.start()
    assert flight.vehicle.mode == AUTO
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 4)
    flight.wait(6.0)
    assert math.hypot(*flight.vehicle.pilot.velocity_enu_m_s[:2]) == pytest.approx(4.0, abs=0.2)
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 5)
    flight.wait(2.0)
    assert flight.vehicle.landed_state is LandedState.LANDING
    flight.wait_until(lambda: not flight.vehicle.armed)
    assert flight.vehicle.snapshot.position_enu_m == pytest.approx((260.0, 300.0, 50.0), abs=2.5)
    heard = flight.asker.heard()
    assert [m.seq for m in heard if m.get_type() == "MISSION_ITEM_REACHED"] == [1, 2, 3, 4, 5]
    assert [m.seq for m in heard if m.get_type() == "MISSION_CURRENT"] == [1, 2, 4, 5]
    texts = [m.text for m in heard if m.get_type() == "STATUSTEXT"]
    assert "Mission: 1 Takeoff" in texts
    assert "Reached command #2" in texts
    (told,) = [m for m in flight.asker.command(512, 42) if m.get_type() == "MISSION_CURRENT"]
    assert (told.seq, told.total, told.mission_state, told.mission_mode) == (5, 5, 5, 1)


def test_waypoints_are_held_and_delays_kept(flight: Flight) -> None:
    flight.load(flight.item(22, up=20.0), flight.item(93, 20.0), flight.item(16, 15.0, up=20.0), flight.item(17))
    flight.arm()
    flight.start()
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 2)
    flight.wait(18.0)
    assert flight.vehicle.auto_flight.current == 2
    flight.wait(4.0)
    assert flight.vehicle.auto_flight.current == 3
    flight.wait(11.0)
    assert flight.vehicle.auto_flight.current == 3
    flight.wait(4.0)
    assert flight.vehicle.auto_flight.current == 4
    flight.wait(30.0)
    assert flight.vehicle.auto_flight.current == 4
    assert flight.vehicle.auto_flight.running


def test_jumps_are_counted(flight: Flight) -> None:
    flight.load(
        flight.item(22, up=20.0),
        flight.item(16, at=(215.0, 200.0), up=20.0),
        flight.item(16, at=(200.0, 200.0), up=20.0),
        flight.item(177, 2.0, 2.0),
        flight.item(19, 2.0, up=20.0),
        flight.item(20),
    )
    flight.arm()
    flight.start()
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 6)
    assert flight.reached() == [1, 2, 3, 2, 3, 2, 3, 5]
    flight.wait_until(lambda: not flight.vehicle.armed)
    home = flight.vehicle.home_enu_m
    assert flight.vehicle.snapshot.position_enu_m == pytest.approx(home, abs=2.5)


def test_a_mission_that_only_jumps_ends(flight: Flight) -> None:
    flight.load(flight.item(22, up=20.0), flight.item(177, 3.0, -1.0), flight.item(177, 2.0, -1.0))
    flight.arm()
    flight.start()
    flight.wait_until(lambda: flight.vehicle.auto_flight.complete)
    assert flight.vehicle.armed
    assert not flight.vehicle.landed


def test_conditions_hold_back_what_follows_them(flight: Flight) -> None:
    flight.load(
        flight.item(22, up=20.0),
        flight.item(16, at=(600.0, 200.0), up=20.0),
        flight.item(112, 5.0),
        flight.item(178, 1.0, 2.0),
        flight.item(16, at=(200.0, 200.0), up=20.0),
    )
    flight.arm()
    flight.start()
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 5)
    flight.wait(4.0)
    assert flight.vehicle.pilot.commanded_speed_m_s is None
    flight.wait(2.0)
    assert flight.vehicle.pilot.commanded_speed_m_s == 2.0


def test_turns_are_flown_round_a_centre(flight: Flight) -> None:
    centre = (300.0, 300.0)
    flight.load(flight.item(22, up=20.0), flight.item(18, 1.0, 0.0, 40.0, at=centre, up=30.0), flight.item(17))
    flight.arm()
    flight.start()
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 2)
    quarters = set()

    def turned() -> bool:
        east, north, _ = flight.vehicle.snapshot.position_enu_m
        if abs(math.hypot(east - centre[0], north - centre[1]) - 40.0) < 8.0:
            quarters.add((east > centre[0], north > centre[1]))
        return bool(flight.vehicle.auto_flight.current == 3)

    flight.wait_until(turned)
    assert len(quarters) == 4


def test_pausing_and_going_on(flight: Flight) -> None:
    """Another mode leaves the mission where it is; AUTO goes on with the same item."""
    flight.load(flight.item(22, up=20.0), flight.item(16, at=(600.0, 200.0), up=20.0), flight.item(17))
    flight.arm()
    flight.start()
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 2)
    flight.wait(5.0)
    assert result(flight.asker.command(176, 1, LOITER), 176) == 0
    flight.wait(5.0)
    state = flight.asker.command(512, 42)[-1]
    assert (state.seq, state.mission_state, state.mission_mode) == (2, 2, 0)
    assert result(flight.asker.command(176, 1, AUTO), 176) == 0
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 3)


def test_going_to_another_item(flight: Flight) -> None:
    flight.load(
        flight.item(22, up=20.0),
        flight.item(16, at=(900.0, 200.0), up=20.0),
        flight.item(16, at=(200.0, 240.0), up=20.0),
        flight.item(17),
    )
    flight.arm()
    flight.start()
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 2)
    flight.asker.heard()
    (told,) = flight.asker.ask(mavlink.MAVLink_mission_set_current_message(1, 1, 3))
    assert (told.get_type(), told.seq) == ("MISSION_CURRENT", 3)
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 4, 60.0)
    answers = flight.asker.command(224, 2)
    assert (result(answers, 224), kinds(answers)[-1]) == (0, "MISSION_CURRENT")
    assert flight.vehicle.auto_flight.current == 2
    assert flight.asker.ask(mavlink.MAVLink_mission_set_current_message(1, 1, 9)) == []
    assert result(flight.asker.command(224, 9), 224) == 2
    assert result(flight.asker.command(224, math.nan), 224) == 2


def test_without_a_mission_there_is_no_auto(flight: Flight) -> None:
    flight.arm()
    assert result(flight.asker.command(176, 1, AUTO), 176) == 4
    assert result(flight.asker.command(300), 300) == 4
    assert flight.asker.ask(mavlink.MAVLink_mission_set_current_message(1, 1, 1)) == []
    assert result(flight.asker.command(224, 1), 224) == 2


def test_a_mission_in_the_air_is_not_cleared_while_it_flies(flight: Flight) -> None:
    flight.load(flight.item(22, up=20.0), flight.item(17))
    flight.arm()
    flight.start()
    flight.wait(3.0)
    flight.asker.heard()
    (answer,) = flight.asker.ask(mavlink.MAVLink_mission_clear_all_message(1, 1, 0))
    assert (answer.get_type(), answer.type) == ("MISSION_ACK", 1)
    assert len(flight.vehicle.flight_plan.mission) == 3


def test_altitudes_above_terrain_count_from_the_ground(flight: Flight) -> None:
    high = flight.item(16, at=(230.0, 200.0), up=33.0)
    above_terrain = PlanItem(16, 10, NONE, high.x, high.y, 33.0)
    flight.load(flight.item(22, up=20.0), above_terrain, flight.item(17))
    flight.arm()
    flight.start()
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 3)
    flight.wait(5.0)
    assert flight.vehicle.snapshot.position_enu_m[2] == pytest.approx(50.0 + 33.0, abs=2.1)


def test_in_auto_on_the_ground_it_waits_for_the_throttle(flight: Flight) -> None:
    flight.load(flight.item(22, up=20.0), flight.item(17))
    flight.arm()
    assert result(flight.asker.command(176, 1, AUTO), 176) == 0
    flight.wait(3.0)
    assert flight.vehicle.landed
    throttle = [65535, 65535, 1500, *[65535] * 5]
    flight.asker.send(mavlink.MAVLink_rc_channels_override_message(1, 1, *throttle))
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 2)


def test_an_armed_copter_on_the_ground_needs_a_takeoff_first(flight: Flight) -> None:
    flight.load(flight.item(16, at=(230.0, 200.0), up=20.0))
    flight.arm()
    assert result(flight.asker.command(176, 1, AUTO), 176) == 4
    flight.wait(0.1)
    assert "Auto: Missing Takeoff Cmd" in [m.text for m in flight.asker.heard() if m.get_type() == "STATUSTEXT"]


def team(kind: str) -> dict[str, Any]:
    vehicle = {
        "name": "one",
        "type": kind,
        "start_enu_m": [200.0, 200.0],
        "speed_m_s": 4.0,
        "sensor": {"kind": "range", "range_m": 100.0},
        "min_above_terrain_m": 2.0,
        "max_above_terrain_m": 100.0,
    }
    return {"team": [vehicle], "terrain": {"kind": "flat", "elevation_amsl_m": 240.0}}


def test_a_boat_sails_its_mission_and_returns() -> None:
    flight = Flight(**team("surface-vessel"))
    flight.load(
        flight.item(22, up=20.0),
        flight.item(16, at=(240.0, 200.0), up=20.0),
        flight.item(178, 1.0, 2.0),
        flight.item(16, at=(240.0, 240.0), up=20.0),
        flight.item(20),
    )
    flight.arm()
    flight.start()
    flight.wait_until(lambda: flight.vehicle.auto_flight.complete, 400.0)
    assert flight.reached() == [1, 2, 3, 4, 5]
    east, north, up = flight.vehicle.true_position_enu_m
    assert math.hypot(east - 200.0, north - 200.0) < 5.0
    assert up == pytest.approx(0.0, abs=0.5)


def test_an_underwater_vehicle_dives_where_its_mission_says() -> None:
    flight = Flight(**team("underwater-vehicle"))
    flight.load(flight.item(16, at=(215.0, 200.0), up=-12.0), flight.item(19, 5.0, up=-12.0), flight.item(16, up=-3.0))
    flight.arm()
    flight.start()
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 2, 300.0)
    assert flight.vehicle.pilot.position_enu_m[2] == pytest.approx(-12.0, abs=2.5)
    flight.wait_until(lambda: flight.vehicle.auto_flight.complete, 300.0)
    assert flight.vehicle.pilot.position_enu_m[2] == pytest.approx(-3.0, abs=2.5)
    assert flight.vehicle.armed


def test_it_returns_to_a_rally_point_that_is_nearer_than_home(flight: Flight) -> None:
    flight.load(flight.item(22, up=20.0), flight.item(16, at=(500.0, 200.0), up=20.0), flight.item(20))
    flight.vehicle.flight_plan.rally = (flight.item(5100, at=(480.0, 220.0), up=20.0),)
    flight.arm()
    flight.start()
    flight.wait_until(lambda: flight.vehicle.auto_flight.current == 3)
    flight.wait_until(lambda: not flight.vehicle.armed)
    assert flight.vehicle.snapshot.position_enu_m == pytest.approx((480.0, 220.0, 50.0), abs=2.5)
