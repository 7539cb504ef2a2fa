"""The same dashboard in a browser, through textual-serve: one dashboard process per visitor."""

from __future__ import annotations

import ipaddress
import shlex
import sys
from collections.abc import Sequence


class ServeError(Exception):
    """Why the dashboard cannot be served, one sentence with the mend."""


def is_loopback(host: str) -> bool:
    """Tell whether only programs on this machine can reach an address."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def serve(arguments: Sequence[str], host: str, port: int, title: str) -> None:
    """Serve until stopped; `arguments` are those of `ground-station` for each visitor. Raises ServeError."""
    try:
        from textual_serve.server import Server
    except ImportError:
        raise ServeError("--serve needs textual-serve; install it with `pip install 'fieldfleet[web]'`") from None
    command = shlex.join([sys.executable, "-m", "ground_station.cli", *arguments])
    try:
        Server(command, host=host, port=port, title=title).serve()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise ServeError(f"{host}:{port}: {reason}; choose another --host or --port") from None
