"""Pure drawing: what lies where on the map, in the curve and in the colours."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground_station.fleet_state import fold
from ground_station.inputs import Heard, Tick
from ground_station.picture import Condition, FleetState
from ground_station.views.curve_view import curve_lines
from ground_station.views.event_view import event_lines
from ground_station.views.header_view import banner_line, header_line
from ground_station.views.ink import Look, filled, fitted, line_of, text_of, width_of, wrapped
from ground_station.views.layout import MIN_HEIGHT, MIN_WIDTH, arrange
from ground_station.views.map_view import map_lines, map_raster
from ground_station.views.palette import CIVIDIS_ANCHORS, cividis, state_mark
from ground_station.views.raster import FRONTIER, OBSERVED, OUTSIDE, UNOBSERVED, rasterise, segment_pixels
from ground_station.views.roster_view import roster_lines
from ground_station.views.viewport import Viewport
from ground_station.widgets.lines import last_difference
from tests.fakes.talking_fleet import NAMES, Voice, small_plan
from vehicle_agent.domain.grid import Grid
from vehicle_agent.wire.messages import Severity, Stage

PLAN = small_plan()
ROWS = PLAN.grid.rows
LOOKS = [Look(), Look(unicode=False), Look(colour=False), Look(unicode=False, colour=False)]


@pytest.fixture
def state() -> FleetState:
    """The western half observed, rising to the north; merlin in the middle of it."""
    merlin = Voice("merlin")
    start = FleetState.initial(PLAN, "station-0001", 9, 0.0)
    bands = [
        merlin.delta([column * ROWS + row for column in range(10)], row, elevation_dm=1_000 + 100 * row)
        for row in range(ROWS)
    ]
    return fold(start, [Heard(message, 0.0) for message in (*bands, merlin.status(60.0), merlin.claim())] + [Tick(0.0)])


class TestRaster:
    @pytest.mark.parametrize(("width", "height"), [(20, 20), (10, 10), (40, 40), (7, 7), (64, 64)])
    def test_north_is_up_and_west_is_left(self, state: FleetState, width: int, height: int) -> None:
        raster = rasterise(state.team_map, Viewport.around(PLAN.grid, width, height))
        assert raster.kind[0, 0] == raster.kind[0, -1] == OBSERVED
        assert raster.kind[-1, 0] == raster.kind[-1, -1] == UNOBSERVED
        assert raster.height_share[0, 0] > raster.height_share[0, -1]
        assert FRONTIER in raster.kind[width // 2 - 2 : width // 2 + 1, height // 2]

    def test_what_the_area_does_not_fill_is_outside(self, state: FleetState) -> None:
        raster = rasterise(state.team_map, Viewport.around(PLAN.grid, 40, 20))
        assert np.all(raster.kind[:10] == OUTSIDE)
        assert np.all(raster.kind[30:] == OUTSIDE)
        assert not np.any(raster.kind[10:30] == OUTSIDE)

    @given(st.integers(1, 80), st.integers(1, 80), st.integers(1, 50), st.integers(1, 50), st.sampled_from([1.0, 2.0]))
    def test_a_view_holds_the_whole_grid(self, width: int, height: int, columns: int, rows: int, aspect: float) -> None:
        grid = Grid(-35.0, 12.0, 7.5, columns, rows)
        view = Viewport.around(grid, width, height, aspect)
        for column, row in ((0, 0), (columns - 1, 0), (0, rows - 1), (columns - 1, rows - 1)):
            assert view.holds(*view.pixel_of(*grid.centre_of(column, row)))
        assert view.pixel_height_m == pytest.approx(aspect * view.pixel_width_m)

    @given(*[st.integers(-30, 60)] * 4)
    def test_a_segment_is_without_gaps_inside_the_view(self, x0: int, y0: int, x1: int, y1: int) -> None:
        view = Viewport(0.0, 40.0, 1.0, 1.0, 30, 40)
        pixels = segment_pixels((x0, y0), (x1, y1), view)
        assert all(view.holds(*pixel) for pixel in pixels)
        for (ax, ay), (bx, by) in pairwise(pixels):
            assert max(abs(ax - bx), abs(ay - by)) == 1

    def test_a_raster_is_made_anew_only_for_another_map_or_view(self, state: FleetState) -> None:
        raster = map_raster(state, 20, 10, Look())
        later = fold(state, [Heard(Voice("osprey").status(61.0), 1.0), Tick(1.0)])
        assert map_raster(later, 20, 10, Look(), raster) is raster
        assert map_raster(later, 21, 10, Look(), raster) is not raster
        grown = fold(later, [Heard(Voice("osprey", 2).delta([399]), 1.0)])
        assert map_raster(grown, 20, 10, Look(), raster).kind[-1, 0] == FRONTIER

    def test_a_position_at_the_end_of_the_world_draws_nothing_and_costs_nothing(self) -> None:
        view = Viewport(0.0, 40.0, 1.0, 1.0, 30, 40)
        assert segment_pixels((0, 0), (10**9, 10**9), view) == []


class TestSizes:
    @pytest.mark.parametrize("look", LOOKS)
    @pytest.mark.parametrize(("width", "height"), [(1, 1), (16, 3), (33, 16), (64, 31), (200, 50)])
    def test_the_map_fills_exactly_its_size(self, state: FleetState, look: Look, width: int, height: int) -> None:
        lines = map_lines(state, map_raster(state, width, height, look), look)
        assert [width_of(line) for line in lines] == [width] * height

    @pytest.mark.parametrize("look", LOOKS)
    def test_without_unicode_every_character_is_ascii_and_without_colour_no_ink_is_coloured(
        self, state: FleetState, look: Look
    ) -> None:
        lines = [
            *map_lines(state, map_raster(state, 33, 16, look), look),
            *roster_lines(state, 46, 13, look),
            *curve_lines(state, 33, 6, look),
            *event_lines(state, 46, 8, look),
            header_line(state, 80, look),
            banner_line(state, "", look),
        ]
        for line in lines:
            assert look.unicode or text_of(line).isascii()
            for _, ink in line:
                assert look.colour or (ink.fg is None and ink.bg is None)

    @given(st.integers(MIN_WIDTH, 300), st.integers(MIN_HEIGHT, 100), st.integers(1, 64), st.floats(0.1, 10))
    def test_the_layout_always_leaves_room_for_everything(
        self, width: int, height: int, vehicles: int, aspect: float
    ) -> None:
        layout = arrange(Grid.over(0.0, 0.0, 1_000.0 * aspect, 1_000.0, 10.0), vehicles, width, height)
        assert 16 <= layout.left_width <= width - 42
        assert layout.roster_height + 5 <= height - 3
        assert layout.curve_height + 1 + 8 <= height - 3

    @given(st.text(st.characters(codec="ascii", exclude_categories=("C",))), st.integers(4, 40), st.integers(0, 20))
    def test_wrapped_lines_fit_and_lose_nothing(self, text: str, width: int, indent: int) -> None:
        lines = wrapped(text, width, min(indent, width))
        assert all(len(line) <= width for line in lines)
        assert "".join(lines).replace(" ", "") == "".join(text.split())

    def test_lines_are_cut_and_filled(self) -> None:
        assert text_of(fitted(line_of("abc", "def"), 4)) == "abcd"
        assert text_of(fitted(line_of("ab"), 4)) == "ab  "
        assert [text_of(line) for line in filled([line_of("a")], 2, 2)] == ["a ", "  "]


class TestMeaning:
    def test_every_state_has_a_glyph_of_its_own_in_both_alphabets(self) -> None:
        merlin = FleetState.initial(PLAN, "station-0001", 9, 0.0).vehicles[0]
        marks = {}
        for condition in Condition:
            for stage in Stage:
                one = type(merlin)(merlin.name, 0, status=Voice("merlin").status(stage=stage), condition=condition)
                unicode_mark, ascii_mark, _ = state_mark(one)
                assert ascii_mark.isascii()
                assert marks.setdefault(unicode_mark, ascii_mark) == ascii_mark
        assert len(set(marks.values())) == len(marks)

    def test_cividis_passes_through_its_anchors_and_grows_lighter(self) -> None:
        assert cividis(10) == CIVIDIS_ANCHORS
        ramp = cividis(16)
        assert (ramp[0], ramp[-1]) == (CIVIDIS_ANCHORS[0], CIVIDIS_ANCHORS[-1])
        lightness = [0.2126 * red + 0.7152 * green + 0.0722 * blue for red, green, blue in ramp]
        assert lightness == sorted(lightness)

    def test_the_curve_reaches_the_height_that_its_number_says(self, state: FleetState) -> None:
        lines = curve_lines(state, 45, 12, Look())
        assert "coverage 50.0%" in text_of(lines[0])
        plot = [text_of(line)[5:] for line in lines[1:-1]]
        assert [row.strip() != "" for row in plot] == [False] * 5 + [True] * 5
        assert plot[5][-1] != " "

    def test_long_events_are_wrapped_and_the_newest_are_kept(self, state: FleetState) -> None:
        merlin = Voice("merlin", boot_id=2)
        messages = [merlin.event(f"number {n} " + "word " * 20, 60.0 + n, Severity.WARNING) for n in range(10)]
        state = fold(state, [Heard(message, 1.0) for message in messages])
        lines = [text_of(line) for line in event_lines(state, 40, 9, Look())]
        assert len(lines) == 9
        assert all(len(line) <= 40 for line in lines)
        assert any("number 9" in line for line in lines)

    def test_a_lost_vehicle_is_drawn_over_its_neighbours(self) -> None:
        statuses = [Heard(Voice(name).status(), 0.0) for name in NAMES]
        state = fold(FleetState.initial(PLAN, "station-0001", 9, 0.0), [*statuses, Tick(0.0)])
        state = fold(state, [*(Heard(Voice(name, 2).status(4.0), 4.0) for name in NAMES[1:]), Tick(4.5)])
        drawn = "\n".join(text_of(line) for line in map_lines(state, map_raster(state, 40, 20, Look()), Look()))
        assert "1✖" in drawn

    def test_records_to_come_are_announced(self, state: FleetState) -> None:
        state = fold(state, [Heard(Voice("kestrel").digest(("osprey", 3, 12)), 0.0)])
        assert "12 map records to come" in text_of(header_line(state, 120, Look()))


class TestRepainting:
    @given(st.text("ab ", min_size=5, max_size=5), st.text("ab ", min_size=5, max_size=5))
    def test_nothing_beyond_the_last_difference_differs(self, before: str, after: str) -> None:
        end = last_difference(line_of(before), line_of(*after))
        assert before[end:] == after[end:]
        assert end == 0 or before[end - 1] != after[end - 1]
