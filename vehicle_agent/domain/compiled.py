"""Machine code for numeric kernels: numba's compiler behind a decorator that keeps a function's types."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType
from typing import Any, ParamSpec, TypeVar

from numba import config, njit
from numba.core.dispatcher import Dispatcher

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile at the first call and keep the result in the cache beside the source (or in the user's cache folder).

    While it runs, other threads may: a heartbeat does not wait for a plan.
    """
    with _cached_by_what_it_calls(function):
        kernel: Callable[P, R] = njit(cache=True, nogil=True)(function)
    return kernel


@contextmanager
def _cached_by_what_it_calls(function: Any) -> Iterator[None]:
    """Lead numba's cache to a folder of its own for each version of the other files whose kernels a kernel calls.

    Numba itself looks at the file of the kernel alone, and would go on with what other files held before. Where the
    folder cannot be written, it does: packages that are installed there are put in place as a whole.
    """
    others = _files_called(function, set()) - {function.__code__.co_filename}
    if not others:
        yield
        return
    stamps = sorted((path.name, path.stat().st_mtime_ns, path.stat().st_size) for path in map(Path, others))
    version = hashlib.sha256(repr(stamps).encode()).hexdigest()[:16]
    before = config.CACHE_DIR
    config.CACHE_DIR = str(Path(before or Path(function.__code__.co_filename).parent / "__pycache__") / version)
    try:
        yield
    finally:
        config.CACHE_DIR = before


def _files_called(function: FunctionType, known: set[str]) -> set[str]:
    """The file of a kernel, and of all whose kernels its module and theirs import by name, added to those known."""
    if function.__code__.co_filename not in known:
        known.add(function.__code__.co_filename)
        for value in list(function.__globals__.values()):
            if isinstance(value, Dispatcher):
                _files_called(value.py_func, known)
    return known
