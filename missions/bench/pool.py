"""Measures a bench's cases on all cores: a progress bar, and Ctrl-C or SIGTERM keeps what is done."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import TypeVar

import click

from missions.launch import PR_SET_PDEATHSIG

Case = TypeVar("Case")
Result = TypeVar("Result")


def measure_all(
    cases: Sequence[Case], measure: Callable[[Case], Result], label: str, processes: int | None = None
) -> tuple[list[Result], bool]:
    """Measure every case in a process of its own choosing; results are in the order of the cases.

    Parameters
    ----------
    measure
        A function at the top of a module, for other processes to find.
    processes
        As many as there are cores when left out.

    Returns
    -------
    The results of the cases that were done, and whether Ctrl-C or SIGTERM came before all were.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a process per core is enough; told to workers as they start
    count = min(processes or os.cpu_count() or 1, len(cases))
    context = multiprocessing.get_context("spawn")  # a fork would copy other libraries' threads half
    done: dict[int, Result] = {}
    with ProcessPoolExecutor(count, mp_context=context, initializer=_begin, initargs=(os.getpid(),)) as pool:
        waiting = {pool.submit(_measured, measure, case): place for place, case in enumerate(cases)}
        was = signal.signal(signal.SIGTERM, signal.default_int_handler)  # whoever ends it wants what is done, too
        try:
            with click.progressbar(length=len(cases), label=label, file=sys.stderr) as bar:
                for future in as_completed(waiting):
                    done[waiting[future]] = future.result()
                    bar.update(1)
        except KeyboardInterrupt:
            print(f"\nstopped after {len(done)} of {len(cases)}; what is done is kept", file=sys.stderr)
            workers = list(multiprocessing.active_children())
            pool.shutdown(wait=False, cancel_futures=True)
            for worker in workers:
                worker.terminate()
        finally:
            signal.signal(signal.SIGTERM, was)
    return [done[place] for place in sorted(done)], len(done) < len(cases)


def _measured(measure: Callable[[Case], Result], case: Case) -> Result:
    """Measure one case: only meanwhile can a worker be ended, for half a result would block the parent for good."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    try:
        return measure(case)
    finally:
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})


def _begin(parent_pid: int) -> None:
    """A worker leaves Ctrl-C to its parent, and does not outlive it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, int(signal.SIGKILL), 0, 0, 0)
    if os.getppid() != parent_pid:  # the parent died before the arrangement was made
        os._exit(1)
