"""What every kind of test may ask for."""

from __future__ import annotations

import fcntl
import os
import signal
import socket
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

INTEGRATION = Path(__file__).parent / "integration"
PORTS_PER_FLEET = 200
LOWEST_BASE = 12_000
HIGHEST_BASE = 32_000
"""Below Linux's ephemeral ports, so that outgoing connections cannot take what was found free."""


settings.register_profile("steady", derandomize=True)
settings.register_profile("search", max_examples=1_000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "steady"))
"""Everybody tries the same examples, so that a test that passed passes; `HYPOTHESIS_PROFILE=search` tries others."""


def pytest_configure() -> None:
    """Programs under test must be able to hear Ctrl-C, also where the test run itself was started deaf to it."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests with real processes need the machine's cores to themselves: `--dist loadgroup` gives them to one worker."""
    for item in items:
        if INTEGRATION in item.path.parents:
            item.add_marker(pytest.mark.xdist_group("processes"))


def _all_free(base: int) -> bool:
    for offset in (*range(8), *range(100, 180, 10)):
        for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM):
            with socket.socket(socket.AF_INET, kind) as probe:
                try:
                    probe.bind(("127.0.0.1", base + offset))
                except OSError:
                    return False
    return True


@pytest.fixture
def free_port_base() -> Iterator[int]:
    """First of a block of ports that are free now: Zenoh's at +0.., MAVLink's at +100...

    A lock on a file keeps the block from every other test on this machine until this one is over.
    """
    folder = Path(tempfile.gettempdir()) / "fieldfleet-test-ports"
    folder.mkdir(exist_ok=True)
    blocks = (HIGHEST_BASE - LOWEST_BASE) // PORTS_PER_FLEET
    for attempt in range(blocks):
        base = LOWEST_BASE + (os.getpid() + attempt) % blocks * PORTS_PER_FLEET
        with (folder / str(base)).open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            if _all_free(base):
                yield base
                return
    raise RuntimeError("no block of free ports")
