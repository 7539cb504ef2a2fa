"""Sketches say what is done around a landmark, and nothing else, whatever the layout and whatever the bytes."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.domain.done_sketch import SKETCH_BYTES, DoneSketch, SketchBook
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmark_layout import LandmarkLayout

SIDES = st.integers(1, 12)


@given(SIDES, SIDES, st.sampled_from([1.0, 6.0]), st.integers(0, 2**32 - 1))
def test_only_what_is_done_is_called_so_and_all_of_it_nearby(
    columns: int, rows: int, patch_m: float, seed: int
) -> None:
    layout = LandmarkLayout.at_cells(Grid(3.0, -7.0, 2.5, columns, rows))
    dice = np.random.default_rng(seed)
    done = dice.random(len(layout)) < 0.8
    place = layout.positions_en_m[dice.integers(len(layout))]
    speaker, listener = SketchBook(layout, patch_m), SketchBook(layout, patch_m)
    called = listener.landmarks_in(speaker.sketch(done, speaker.centre_at(place[0], place[1])))
    assert done[called].all()
    everything = speaker.landmarks_in(speaker.sketch(np.ones_like(done), speaker.centre_at(place[0], place[1])))
    assert len(everything) >= min(8 * SKETCH_BYTES, len(layout))
    away = np.linalg.norm(layout.positions_en_m - place, axis=1)
    assert np.isin(np.flatnonzero(away < 6.0), everything).all()
    if patch_m < layout.spacing_m:
        assert called.tolist() == everything[done[everything]].tolist()


@given(st.integers(-(2**40), 2**40), st.binary(max_size=40))
def test_any_bytes_call_done_only_what_there_is(centre: int, bits: bytes) -> None:
    book = SketchBook(LandmarkLayout.at_cells(Grid(0.0, 0.0, 1.0, 5, 4)), 1.0)
    read = book.landmarks_in(DoneSketch(centre, bits))
    assert set(read.tolist()) <= set(range(20))
    if not 0 <= centre < 20 or len(bits) != SKETCH_BYTES:
        assert len(read) == 0
