"""Machine code for numeric kernels: numba's compiler behind a decorator that keeps a function's types."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from numba import njit

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile at the first call and keep the result in the cache beside the source (or in the user's cache folder).

    While it runs, other threads may: a heartbeat does not wait for a plan.
    """
    kernel: Callable[P, R] = njit(cache=True, nogil=True)(function)
    return kernel
