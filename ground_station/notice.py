"""The line that whoever started the dashboard wants shown until the first vehicle is live."""

from __future__ import annotations

from pathlib import Path

MAX_NOTICE = 200


def read_notice(path: Path | None) -> str:
    """The file's first line, safe to show by `text.clean`; empty when there is no file or nothing in it."""
    if path is None:
        return ""
    try:
        with path.open("rb") as file:
            lines = file.read(MAX_NOTICE).decode("utf-8", "replace").splitlines()
    except OSError:
        return ""
    return lines[0].strip() if lines else ""
