"""Which of an operator's commands a vehicle obeys: each once, and only where it makes sense."""

from __future__ import annotations

from vehicle_agent.wire.messages import Command, Outcome, Stage, Verb

STALE_MS = 10_000
"""A command said so long before this agent began was meant for the one before it."""
_POSSIBLE_IN: dict[Verb, frozenset[Stage]] = {
    Verb.HOLD: frozenset({Stage.WORKING, Stage.RETURNING, Stage.LANDING, Stage.YIELDED}),
    Verb.RESUME: frozenset({Stage.HOLDING, Stage.RETURNING, Stage.YIELDED}),
    Verb.RETURN: frozenset({Stage.TAKING_OFF, Stage.WORKING, Stage.HOLDING, Stage.YIELDED}),
    Verb.LAND: frozenset({Stage.TAKING_OFF, Stage.WORKING, Stage.HOLDING, Stage.RETURNING, Stage.YIELDED}),
    Verb.GO_TO: frozenset({Stage.WORKING, Stage.HOLDING, Stage.RETURNING}),
    Verb.VISIT: frozenset({Stage.WORKING, Stage.HOLDING, Stage.RETURNING}),
}
_ALWAYS = frozenset(Stage) - {Stage.DONE, Stage.REFUSED}
"""Standing orders are taken before take-off too."""


class CommandDesk:
    """Judges commands for one vehicle and remembers which it has answered."""

    def __init__(self, own_name: str) -> None:
        self._own_name = own_name
        self._answered: set[tuple[str, int, int]] = set()

    def judge(self, command: Command, stage: Stage, began_ms: int = 0) -> tuple[Outcome, str] | None:
        """Outcome and reason, or None when the command is for others or was answered before.

        `began_ms` is the stamp of this agent's first state: stations' commands are shown to late joiners too.
        """
        identity = (command.sender, command.boot_id, command.command_id)
        if self._own_name not in command.targets or identity in self._answered:
            return None
        self._answered.add(identity)
        if command.stamp_ms < began_ms - STALE_MS:
            return (Outcome.REFUSED, "said before this agent began: say it again")
        if stage in _POSSIBLE_IN.get(command.verb, _ALWAYS):
            return (Outcome.ACCEPTED, "")
        verb = command.verb.name.lower().replace("_", " ")
        return (Outcome.REFUSED, f"cannot {verb} while {stage.name.lower().replace('_', ' ')}")
