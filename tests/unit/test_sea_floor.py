"""The sea floors' detail continues the roughness that the real data have: its power law, its strength, its places."""

from __future__ import annotations

import numpy as np
import pytest

from missions.terrain.sea_floor import CELL_M, SIDE_M, Roughness, roughness_of, sea_floor
from vehicle_agent.domain.frames import FloatArray


def drawn(roughness: Roughness, cells: int, cell_m: float, seed: int) -> FloatArray:
    """A field of all waves that the grid carries."""
    axis = 2.0 * np.pi * np.fft.fftfreq(cells, cell_m)
    wave_number = np.hypot(axis[:, None], axis)
    wave_number[0, 0] = np.inf
    amplitude = np.sqrt(roughness.density(wave_number)) * 2.0 * np.pi / cell_m
    noise = np.random.default_rng(seed).standard_normal((cells, cells))
    field: FloatArray = np.fft.ifft2(np.fft.fft2(noise) * amplitude).real
    return field


@pytest.mark.parametrize("hurst", [0.4, 0.75])
def test_a_power_law_is_found_again_in_what_was_drawn_from_it(hurst: float) -> None:
    # Every eighth cell is kept: waves shorter than a cell would be missing from the finest differences otherwise.
    pieces = [drawn(Roughness(hurst, 0.05), 512, 0.5, seed)[::8, ::8] for seed in range(3)]
    fits = [roughness_of(piece, 4.0) for piece in pieces]
    assert np.mean([fit.hurst for fit in fits]) == pytest.approx(hurst, abs=0.08)
    assert np.mean([fit.increment_m2 for fit in fits]) == pytest.approx(0.05, rel=0.35)


def test_detail_is_where_the_data_are_rough() -> None:
    """The canyon's head is rough and the shelf is even; the detail of waves under ten metres follows."""
    roughest = []
    for seed in range(4):
        floor = sea_floor("sharp", seed)
        assert floor.shape == (round(SIDE_M / CELL_M),) * 2
        fine = floor[4:] - floor[:-4]
        fine = fine[4:] - fine[:-4]
        parts = [
            np.sqrt(np.mean(part**2)) for half in np.array_split(fine, 2) for part in np.array_split(half, 2, axis=1)
        ]
        roughest.append(max(parts) / min(parts))
    assert min(roughest) > 2.5
