"""The fleet on its clock: repeatable, and judged by a referee who sees the truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from sim_bridge.cli import main
from sim_bridge.fleet import Fleet
from sim_bridge.payload import BODY_PERIOD_US, Payload
from sim_bridge.result import result_of
from sim_bridge.world import World
from tests.fakes.sim_missions import sim_plan
from tests.fakes.simulator import write_mission
from vehicle_agent.wire.cells import unpack_cells
from vehicle_agent.wire.messages import AnyMessage, BodyReport, Scan


def new_fleet(vehicles: int = 2) -> Fleet:
    plan = sim_plan(vehicles=vehicles)
    return Fleet(plan, World.of(plan))


def launch(fleet: Fleet) -> None:
    fleet.step(6.0)
    for number, copter in enumerate(fleet.vehicles):
        assert copter.arm().accepted
        assert copter.take_off(30.0 + number).accepted
    fleet.step(30.0)


def test_the_same_orders_give_the_same_flight() -> None:
    flights = []
    for _ in range(2):
        fleet = new_fleet()
        launch(fleet)
        fleet.vehicles[0].go_to((600.0, 700.0, 120.0))
        fleet.step(33.3)
        flights.append([copter.snapshot for copter in fleet.vehicles])
    assert flights[0] == flights[1]


def test_time_is_counted_without_drift_in_steps_of_any_size() -> None:
    fleet = new_fleet(1)
    for _ in range(1000):
        fleet.step(0.1)
    fleet.step(0.033)
    assert fleet.clock.elapsed_us == 100_033_000
    assert fleet.vehicles[0].snapshot.stamp_ms == 1_767_225_600_000 + 100_033


def test_parameters_belong_to_one_vehicle() -> None:
    fleet = new_fleet()
    fleet.vehicles[0].set_parameter("RTL_ALT", 9000)
    assert fleet.vehicles[1].parameters["RTL_ALT"] == 1500
    assert [int(copter.parameters["SYSID_THISMAV"]) for copter in fleet.vehicles] == [1, 2]


def test_separation_counts_only_between_vehicles_in_the_air() -> None:
    fleet = new_fleet()
    fleet.step(6.0)
    fleet.vehicles[0].arm()
    fleet.vehicles[0].take_off(30.0)
    fleet.step(20.0)
    assert result_of(fleet, 0)["min_separation_m"] is None
    fleet.vehicles[1].arm()
    fleet.vehicles[1].take_off(30.0)
    fleet.step(30.0)
    assert fleet.referee.min_separation_m == pytest.approx(40.0, abs=0.1)
    fleet.vehicles[1].go_to((203.0, 200.0, 80.0))
    fleet.step(30.0)
    assert fleet.referee.min_separation_m == pytest.approx(3.0, abs=0.1)


def test_leaving_the_area_is_a_breach_each_time() -> None:
    fleet = new_fleet(1)
    launch(fleet)
    for east_m in (-100.0, 200.0, -100.0):
        fleet.vehicles[0].go_to((east_m, 200.0, 80.0))
        fleet.step(60.0)
    assert fleet.referee.fence_breaches == 2
    assert fleet.referee.outside_s > 30.0


class Said:
    """Keeps what a payload publishes."""

    def __init__(self) -> None:
        self.messages: list[tuple[AnyMessage, str | None]] = []

    def publish(self, message: AnyMessage, participant: str | None = None) -> None:
        self.messages.append((message, participant))


def test_the_payload_says_scans_of_armed_vehicles_and_reports_of_all() -> None:
    fleet, said = new_fleet(), Said()
    payload = Payload(fleet, said, boot_id=7)
    fleet.step(6.0)
    fleet.vehicles[1].arm()
    fleet.vehicles[1].take_off(40.0)
    for _ in range(20 * 10):
        fleet.step(0.05)
        payload.tick()
    scans = [(m, who) for m, who in said.messages if isinstance(m, Scan)]
    assert {who for _, who in scans} == {"copter-1"}
    assert len(scans) == 10
    cells = unpack_cells(scans[-1][0].cells, fleet.plan.grid.cells)
    assert cells is not None
    assert set(cells.stamps_ms.tolist()) == {scans[-1][0].stamp_ms}
    np.testing.assert_array_equal(np.unique(cells.elevations_dm), [500])
    reports = [m for m, _ in said.messages if isinstance(m, BodyReport)]
    assert len(reports) == 2 * (10_000_000 // BODY_PERIOD_US)
    assert {(r.vehicle, r.has_flown) for r in reports[-2:]} == {("copter-0", False), ("copter-1", True)}
    sequences = [message.sequence for message, _ in said.messages]
    assert sequences == sorted(set(sequences))


@pytest.mark.parametrize(
    ("name", "kind", "autopilot", "words"),
    [
        ("merlin", "blimp", "ardupilot", "vehicles[0].type: 'blimp' is not known; choose 'multicopter'"),
        ("merlin", "multicopter", "paparazzi", "vehicles[0].autopilot: 'paparazzi' is not known"),
        ("tern", "surface-vessel", "px4", "vehicles[0].autopilot: a surface-vessel cannot be simulated as px4"),
    ],
)
def test_a_vehicle_of_no_known_kind_is_one_sentence(
    tmp_path: Path, name: str, kind: str, autopilot: str, words: str
) -> None:
    outcome = CliRunner().invoke(main, [str(write_mission(tmp_path, (name, kind, autopilot)))])
    assert outcome.exit_code == 2
    assert words in outcome.output
    assert outcome.output.count("\n") == 1
