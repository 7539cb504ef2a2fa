"""Says things: stamps every message with who says it, from which boot, in which order and when."""

from __future__ import annotations

from typing import Any, TypeVar

from vehicle_agent.wire.messages import Event, Message, Severity

M = TypeVar("M", bound=Message)


class Voice:
    """One sender's numbered messages, collected until the step ends."""

    def __init__(self, name: str, boot_id: int) -> None:
        self.name = name
        self.boot_id = boot_id
        self.stamp_ms = 0
        self._sequence = 0
        self._said: list[Message] = []

    def say(self, message: type[M], **fields: Any) -> None:
        """Build a message of the given type and queue it."""
        self._said.append(
            message(sender=self.name, boot_id=self.boot_id, sequence=self._sequence, stamp_ms=self.stamp_ms, **fields)
        )
        self._sequence += 1

    def event(self, severity: Severity, code: str, text: str) -> None:
        self.say(Event, severity=severity, code=code, text=text[:160])

    def take(self) -> list[Any]:
        """Everything said since the last call, in order."""
        said, self._said = self._said, []
        return said
