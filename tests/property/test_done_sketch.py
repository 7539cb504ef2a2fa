"""Sketches say what is done around a landmark, and nothing else, whatever the layout and whatever the bytes."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.domain.done_sketch import SKETCH_BYTES, DoneSketch, SketchBook
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmarks import LandmarkLayout

SIDES = st.integers(1, 12)


@given(SIDES, SIDES, st.integers(0, 2**32 - 1))
def test_what_is_read_is_what_is_done_of_the_nearest(columns: int, rows: int, seed: int) -> None:
    layout = LandmarkLayout.at_cells(Grid(3.0, -7.0, 2.5, columns, rows))
    dice = np.random.default_rng(seed)
    done = dice.random(len(layout)) < 0.5
    centre = int(dice.integers(len(layout)))
    around = SketchBook(layout).around(centre)
    assert len(around) == min(8 * SKETCH_BYTES, len(layout))
    away = np.linalg.norm(layout.positions_en_m - layout.positions_en_m[centre], axis=1)
    assert away[around].max() <= np.sort(away)[len(around) - 1] + 1e-2
    read = SketchBook(layout).done_in(SketchBook(layout).sketch(done, centre))
    assert read.tolist() == around[done[around]].tolist()


@given(st.integers(-(2**40), 2**40), st.binary(max_size=40))
def test_any_bytes_call_done_only_what_there_is(centre: int, bits: bytes) -> None:
    layout = LandmarkLayout.at_cells(Grid(0.0, 0.0, 1.0, 5, 4))
    read = SketchBook(layout).done_in(DoneSketch(centre, bits))
    assert set(read.tolist()) <= set(range(20))
    if not 0 <= centre < 20 or len(bits) != SKETCH_BYTES:
        assert len(read) == 0
