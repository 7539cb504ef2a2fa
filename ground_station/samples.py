"""Short histories that a picture carries: bounded, thinned, immutable."""

from __future__ import annotations

from vehicle_agent.wire.messages import Status

MAX_TRAIL_POINTS = 300


def windowed(
    samples: tuple[tuple[float, int], ...], sample: tuple[float, int], window: float
) -> tuple[tuple[float, int], ...]:
    """Samples with one more, without those older than the window (one of them stays as its beginning)."""
    joined = (*samples, sample)
    first = 0
    while first + 2 < len(joined) and joined[first + 1][0] <= sample[0] - window:
        first += 1
    return joined[first:]


def trail_with(
    trail: tuple[tuple[float, float], ...], status: Status, spacing_m: float
) -> tuple[tuple[float, float], ...]:
    """The trail with the status's position, unless too near to the last; its older half is thinned when full."""
    east, north = status.position_cm[0] / 100, status.position_cm[1] / 100
    if trail and (trail[-1][0] - east) ** 2 + (trail[-1][1] - north) ** 2 < spacing_m**2:
        return trail
    joined = (*trail, (east, north))
    if len(joined) <= MAX_TRAIL_POINTS:
        return joined
    half = MAX_TRAIL_POINTS // 2
    return (*joined[:half:2], *joined[half:])
