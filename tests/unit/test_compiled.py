"""Compiled kernels and their cache."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

KERNEL = "from vehicle_agent.domain.compiled import compiled\n"


def answer_of(folder: Path) -> str:
    """What the kernel `outer` says in a process of its own."""
    command = [sys.executable, "-c", "from outer import outer; print(outer())"]
    found_in = os.pathsep.join([str(folder), *sys.path])
    done = subprocess.run(
        command, env=os.environ | {"PYTHONPATH": found_in}, capture_output=True, text=True, check=True, timeout=120
    )
    return done.stdout.strip()


def write_inner(folder: Path, value: int, mtime_s: int) -> None:
    path = folder / "inner.py"
    path.write_text(f"{KERNEL}@compiled\ndef inner():\n    return {value}\n")
    os.utime(path, (mtime_s, mtime_s))


@pytest.mark.parametrize("between", [False, True])
def test_a_kernel_is_compiled_anew_when_one_that_it_calls_has_changed(tmp_path: Path, between: bool) -> None:
    """Also where it calls it by way of a third file, which stays as it is."""
    called = "middle" if between else "inner"
    (tmp_path / "middle.py").write_text(
        f"{KERNEL}from inner import inner\n@compiled\ndef middle():\n    return inner()\n"
    )
    (tmp_path / "outer.py").write_text(
        f"{KERNEL}from {called} import {called}\n@compiled\ndef outer():\n    return {called}()\n"
    )
    write_inner(tmp_path, 1, 1_000_000_000)
    assert answer_of(tmp_path) == "1"
    write_inner(tmp_path, 2, 1_000_000_100)
    assert answer_of(tmp_path) == "2"
