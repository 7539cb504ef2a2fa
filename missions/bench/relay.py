"""A TCP relay that can be cut: to both ends it looks as if the radio between them were out of reach."""

from __future__ import annotations

import selectors
import socket
import threading
from collections.abc import Iterable, Sequence

PASS_S = 0.02
CHUNK_BYTES = 65_536


class Relay:
    """Listens on a port per line, and carries bytes both ways to that line's target.

    While a line is cut nothing is read from it: what is under way waits as it does in TCP over a dead radio, and
    nobody is told.

    Parameters
    ----------
    targets
        (host, port) of each line.

    Attributes
    ----------
    ports
        On loopback, in the order of the targets.
    """

    def __init__(self, targets: Sequence[tuple[str, int]]) -> None:
        self._targets = list(targets)
        self._doors = [socket.create_server(("127.0.0.1", 0)) for _ in targets]
        self.ports = [door.getsockname()[1] for door in self._doors]
        self._cut: frozenset[int] = frozenset()
        self._ends: dict[socket.socket, tuple[int, socket.socket]] = {}
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="relay", daemon=True)

    def __enter__(self) -> Relay:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopping.set()
        self._thread.join(5.0)
        for one in [*self._doors, *self._ends]:
            one.close()

    def cut(self, lines: Iterable[int]) -> None:
        """Carry nothing on these lines until further notice, and everything on all others."""
        self._cut = frozenset(lines)

    def _run(self) -> None:
        while not self._stopping.is_set():
            cut = self._cut
            with selectors.DefaultSelector() as selector:
                for line, door in enumerate(self._doors):
                    if line not in cut:
                        selector.register(door, selectors.EVENT_READ, line)
                for end, (line, _) in self._ends.items():
                    if line not in cut:
                        selector.register(end, selectors.EVENT_READ, None)
                while cut is self._cut and not self._stopping.is_set() and self._pass(selector):
                    pass

    def _pass(self, selector: selectors.DefaultSelector) -> bool:
        """Carry what there is; False when connections came or went."""
        if not selector.get_map():
            self._stopping.wait(PASS_S)
            return True
        same = True
        for key, _ in selector.select(PASS_S):
            end = key.fileobj
            assert isinstance(end, socket.socket)
            if key.data is not None:
                self._join(end, key.data)
                same = False
            elif end in self._ends and not self._carry(end):
                same = False
        return same

    def _join(self, door: socket.socket, line: int) -> None:
        caller, _ = door.accept()
        try:
            target = socket.create_connection(self._targets[line], 1.0)
        except OSError:
            caller.close()
            return
        for one in (caller, target):
            one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._ends[caller] = (line, target)
        self._ends[target] = (line, caller)

    def _carry(self, end: socket.socket) -> bool:
        _, other = self._ends[end]
        try:
            part = end.recv(CHUNK_BYTES)
            other.sendall(part)
        except OSError:
            part = b""
        if part:
            return True
        for one in (end, other):
            del self._ends[one]
            one.close()
        return False
