"""Becomes another program that dies with its parent: `python launch.py PARENT_PID SIGNAL PROGRAM [ARGUMENT ...]`.

The kernel sends SIGNAL when the parent ends, however it ends; `execv` keeps that arrangement. It is a program of its
own rather than a `preexec_fn`, because Python code between fork and exec is unsafe in a parent that has threads.
Standard library only, so that it starts in a few milliseconds with `python -I -S`.
"""

import ctypes
import os
import sys

PR_SET_PDEATHSIG = 1
"""From linux/prctl.h."""


def main() -> None:
    parent_pid, death_signal, *program = sys.argv[1:]
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, int(death_signal), 0, 0, 0)
    if os.getppid() != int(parent_pid):  # the parent died before the arrangement was made
        raise SystemExit(1)
    os.execv(program[0], program)


if __name__ == "__main__":
    main()
