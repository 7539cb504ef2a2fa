"""Waiting in tests: for a condition, with a deadline that only a failure reaches."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

DEADLINE_S = 90.0
PAUSE_S = 0.01


def until(condition: Callable[[], bool], what: str = "a condition", within_s: float = DEADLINE_S) -> None:
    """Ask again and again until it holds; the test fails when it does not in time."""
    deadline_s = time.monotonic() + within_s
    while not condition():
        if time.monotonic() > deadline_s:
            pytest.fail(f"still waiting for {what}")
        time.sleep(PAUSE_S)
