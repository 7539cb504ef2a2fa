"""What a station makes of landmarks: heights, who measured, and how sure it is; and layers that nobody feeds say so."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from ground_station.fleet_state import fold
from ground_station.inputs import FleetInput, Heard, Tick
from ground_station.picture import FleetState
from ground_station.views.curve_view import curve_lines
from ground_station.views.ink import Look, text_of
from ground_station.views.map_view import caption, map_raster
from ground_station.views.raster import FRONTIER, OBSERVED
from ground_station.views.window import Ground, MapWindow
from tests.fakes.pictures import same_picture
from tests.fakes.talking_fleet import EPOCH_MS, small_plan
from vehicle_agent.domain.landmark_records import ACCURATE, QUANTA_PER_ACCURATE_SD, LandmarkRecords
from vehicle_agent.mission.load import MissionPlan, plan_mission
from vehicle_agent.mission.model import Mission
from vehicle_agent.mission.talk import status_period_s
from vehicle_agent.wire.landmark_blob import pack_landmarks
from vehicle_agent.wire.messages import Landmarks

ACCURATE_SD_M = 0.2
LOOK = Look()


@pytest.fixture(scope="module")
def plan() -> MissionPlan:
    vehicle = {
        "type": "underwater-vehicle",
        "speed_m_s": 1.5,
        "depth_m": 2.0,
        "sensor": {"kind": "single-beam", "range_m": 40.0},
        "min_above_terrain_m": 1.0,
        "max_above_terrain_m": 40.0,
    }
    content = {
        "format": 1,
        "name": "basin",
        "datum": {"latitude_deg": 41.0, "longitude_deg": -8.0},
        "area": {"cell_m": 5.0, "rectangle_enu_m": [0.0, 0.0, 100.0, 100.0]},
        "terrain": {"kind": "flat", "elevation_amsl_m": -20.0},
        "task": {"kind": "map", "accurate_sd_m": ACCURATE_SD_M},
        "vehicles": [
            {"name": "alba", "start_enu_m": [20.0, 5.0], **vehicle},
            {"name": "brisa", "start_enu_m": [60.0, 5.0], **(vehicle | {"depth_m": 4.0})},
        ],
        "safety": {"separation_m": 1.0},
    }
    return plan_mission(msgspec.convert(content, Mission))


def told(name: str, sequence: int, ids: range, information: int, height_m: float = -12.0) -> Heard:
    """Landmarks each measured once by that vehicle."""
    count = len(ids)
    quanta = round(height_m / (ACCURATE_SD_M / QUANTA_PER_ACCURATE_SD))
    columns = (list(ids), [("alba", "brisa").index(name)] * count, [1] * count, [quanta] * count, [information] * count)
    records = LandmarkRecords(*(np.array(values, dtype=np.int64) for values in columns))
    message = Landmarks(
        sender=name, boot_id=1, sequence=sequence, stamp_ms=EPOCH_MS + 1_000 * sequence, position_cm=(0, 0, -200),
        position_sd_cm=50, records=pack_landmarks(records),
    )  # fmt: skip
    return Heard(message, float(sequence))


def picture(plan: MissionPlan, *events: FleetInput) -> FleetState:
    return fold(FleetState.initial(plan, "station-0001", 9, 0.0), [*events, Tick(10.0)])


def test_landmarks_become_ground_with_its_uncertainty(plan: MissionPlan) -> None:
    state = picture(plan, told("alba", 1, range(100), ACCURATE // 4), told("brisa", 2, range(50, 150), ACCURATE // 4))
    assert state.team_map.observed_cells == 150
    assert state.team_map.first_seen_cells == (100.0, 50.0)
    assert state.team_map.elevation.elevation_dm.ravel()[70] == -120
    assert state.landmarks is not None
    sd_m = state.landmarks.sd_m.ravel()
    assert sd_m[10] == pytest.approx(2 * ACCURATE_SD_M)
    assert sd_m[70] == pytest.approx(2 * ACCURATE_SD_M / np.sqrt(2))
    assert np.isinf(sd_m[200])
    assert state.counters.bad == 0


def test_the_order_and_repetition_of_packets_do_not_matter(plan: MissionPlan) -> None:
    packets = [told("alba", 1, range(60), 300), told("brisa", 2, range(30, 90), 500), told("alba", 3, range(9), 900)]
    one, other = picture(plan, *packets), picture(plan, *reversed(packets), packets[0])
    assert one.landmarks == other.landmarks
    assert not same_picture(one, picture(plan, packets[0]))


def test_bytes_that_are_no_records_are_counted(plan: MissionPlan) -> None:
    packet = told("alba", 1, range(3), 300).message
    state = picture(plan, Heard(msgspec.structs.replace(packet, records=b"\xff" * 9), 1.0))
    assert state.counters.malformed == 1
    assert picture(small_plan(), Heard(msgspec.structs.replace(packet, sender="merlin"), 1.0)).counters.foreign == 1


def test_the_uncertainty_layer_is_drawn_where_it_is_told_and_redrawn_with_news(plan: MissionPlan) -> None:
    window = MapWindow(ground=Ground.UNCERTAINTY)
    state = picture(plan, told("alba", 1, range(400), ACCURATE // 4))
    raster = map_raster(state, 20, 10, LOOK, None, window)
    assert 0.0 < raster.height_share.max() <= 0.5
    assert "sd 0" in text_of(caption(raster, 60, LOOK))
    assert "0.8 m" in text_of(caption(raster, 60, LOOK))
    surer = fold(state, [told("brisa", 2, range(400), 4 * ACCURATE)])
    assert surer.team_map is state.team_map
    assert map_raster(surer, 20, 10, LOOK, raster, window) is not raster
    assert map_raster(state, 20, 10, LOOK, raster, window) is raster


def test_the_ground_between_landmarks_is_drawn_where_it_is_certain_enough(plan: MissionPlan) -> None:
    """Every other column of the western half is told: the columns between are drawn too, the far east is not."""
    packets = [told("alba", 1 + column, range(20 * column, 20 * column + 20), 4 * ACCURATE) for column in (0, 2, 4, 6)]
    state = picture(plan, *packets)
    assert state.landmarks is not None
    assert state.landmarks.drawn is not None
    assert state.landmarks.drawn.elevation_m[3] == pytest.approx(-12.0, abs=0.3)
    assert state.landmarks.drawn.sd_m[3].max() < state.landmarks.drawn.sd_m[19].min()
    kinds = map_raster(state, 20, 10, LOOK, None, MapWindow()).kind
    seen_alone = map_raster(state, 20, 10, LOOK, None, MapWindow(ground=Ground.OBSERVED)).kind
    assert (kinds == OBSERVED).sum() > (seen_alone == OBSERVED).sum()
    assert not (kinds == FRONTIER).any(), "soundings are scattered: there is no edge to explore"
    assert "±" in text_of(curve_lines(state, 40, 6, LOOK)[0])


def test_the_surface_is_not_drawn_anew_for_every_landmark(plan: MissionPlan) -> None:
    first = picture(plan, told("alba", 1, range(100), ACCURATE))
    more = fold(first, [told("alba", 2, range(100, 103), ACCURATE)])
    much = fold(first, [told("alba", 2, range(100, 140), ACCURATE)])
    assert first.landmarks
    assert more.landmarks
    assert much.landmarks
    assert first.landmarks.drawn is more.landmarks.drawn is not None
    assert much.landmarks.drawn is not first.landmarks.drawn


def test_a_modems_seldom_status_is_not_overdue(plan: MissionPlan) -> None:
    """Of three packets, one every so many seconds, one is a status."""
    modem = msgspec.structs.replace(plan.mission.radio, packet_bytes=200, packet_period_s=10.0)
    quiet = plan_mission(msgspec.structs.replace(plan.mission, radio=modem))
    assert status_period_s(quiet) == 30.0
    assert status_period_s(small_plan()) == 1.0


@pytest.mark.parametrize("ground", [Ground.UNCERTAINTY, Ground.BELIEF])
def test_a_layer_that_nobody_feeds_says_so(ground: Ground) -> None:
    state = FleetState.initial(small_plan(), "station-0001", 9, 0.0)
    raster = map_raster(state, 20, 10, LOOK, None, MapWindow(ground=ground))
    assert f"{ground.value}: not told in this mission" in text_of(caption(raster, 80, LOOK))
