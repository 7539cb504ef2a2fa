"""What real autopilots answered: text lines of recorded replies, read back into messages and their fields."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

NAME_WIDTH = 55
NO_REPLY = "(no reply)"
_MESSAGE = re.compile(r"([A-Z][A-Z0-9_]+) \{(.*)", re.DOTALL)
_FIELD = re.compile(r"([A-Za-z_0-9]+) : ((?:\[[^\]]*\]|[^,\[{}]|,(?! [A-Za-z_0-9]+ : ))+)(?=, |\}|$)")
_COUNT = re.compile(r"'([A-Z0-9_]+)': ([0-9.]+)")


@dataclass(frozen=True)
class Reply:
    """One message: its name and its fields as text, so far as they are known."""

    kind: str
    fields: dict[str, str]

    def __str__(self) -> str:
        return f"{self.kind} {{{', '.join(f'{name} : {value}' for name, value in self.fields.items())}}}"


@dataclass(frozen=True)
class Recorded:
    """One line of a recording.

    Attributes
    ----------
    name
        The question.
    replies
        Messages, the last one without the field that was cut off.
    rates
        Of lines that count messages: how often each kind came, as far as the line goes.
    text
        The whole line.
    """

    name: str
    replies: tuple[Reply, ...]
    rates: dict[str, float]
    text: str


def recorded_answers(firmware: str) -> dict[str, Recorded]:
    """The recording of `copter`, `rover` or `sub`, by question."""
    path = Path(__file__).parent / "golden" / f"ardupilot_{firmware}.txt"
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    return {answer.name: answer for answer in map(_read, lines)}


def reply_of(text: str) -> Reply | None:
    """Read a message as pymavlink prints it; None when it is none."""
    match = _MESSAGE.match(text)
    if match is None:
        return None
    body = match[2]
    fields = dict(_FIELD.findall(body))
    if not body.endswith("}") and fields:
        fields.popitem()
    return Reply(match[1], {name: value.strip() for name, value in fields.items()})


def _read(line: str) -> Recorded:
    heads = (
        "heartbeats in 3.2s",
        "unsolicited in 3s",
        "PARAM_REQUEST_LIST",
        "   n retries",
        "after REQUEST_DATA_STREAM",
    )
    for head in heads:
        if line.startswith(head):
            rates = {kind: float(count) for kind, count in _COUNT.findall(line)}
            return Recorded(head.strip(), (), rates, line)
    name, rest = line[:NAME_WIDTH].strip(), line[NAME_WIDTH:].strip()
    replies = [reply for part in rest.split(" | ") if (reply := reply_of(part)) is not None]
    return Recorded(name, tuple(replies), {}, line)
