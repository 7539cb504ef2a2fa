"""A bench's workers: whenever one is told to end, what it has measured arrives whole."""

from __future__ import annotations

import os
import signal

from missions.bench.pool import measure_all


class Measured:
    """A result whose worker is told to end while it hands it over."""

    def __reduce__(self) -> tuple[type[int], tuple[int]]:
        os.kill(os.getpid(), signal.SIGTERM)
        return (int, (7,))


def measured(_case: int) -> object:
    return Measured()


def test_who_is_told_to_end_hands_over_what_it_has_first() -> None:
    assert measure_all([1], measured, "trial", 1) == ([7], False)
