"""Orders over time: what was sent, what each vehicle answered, and who has not answered in time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ground_station.inputs import CommandSent
from ground_station.payload import verb_word
from ground_station.picture import COMMAND_TIMEOUT_S, Answer, CommandTrack, FleetState
from ground_station.text import clean
from vehicle_agent.wire.messages import Command, CommandResult, Outcome, Severity

MAX_COMMANDS = 20
News = tuple[str, Severity, str, str]
"""Source, severity, code and text of a line for the event log."""


class CommandLog:
    """The orders of one batch of inputs in the making."""

    def __init__(self, state: FleetState) -> None:
        self._tracks = list(state.commands)
        self._station = (state.station, state.station_boot_id)

    @property
    def tracks(self) -> tuple[CommandTrack, ...]:
        return tuple(self._tracks[-MAX_COMMANDS:])

    def sent(self, event: CommandSent) -> News:
        """Take in what this station ordered."""
        self._tracks.append(CommandTrack(event.command, event.sent_s))
        return self.overheard(event.command)

    def overheard(self, command: Command) -> News:
        """What any station orders."""
        verb = verb_word(command.verb)
        return (command.sender, Severity.NOTICE, f"{verb}-sent", f"{verb} sent to {', '.join(command.targets)}")

    def answered(self, result: CommandResult) -> News:
        """Take in a vehicle's answer; one to another station is only told."""
        good = result.outcome is Outcome.ACCEPTED
        verb, word, text = verb_word(result.verb), "accepted" if good else "refused", clean(result.text)
        mine = (result.station, result.station_boot_id) == self._station
        for at, track in enumerate(self._tracks):
            if mine and track.command.command_id == result.command_id and result.sender in track.command.targets:
                answers = {**track.answers, result.sender: Answer(result.outcome, text)}
                self._tracks[at] = replace(track, answers=answers)
        asked_by = "" if mine else f" ({clean(result.station)})"
        severity = Severity.NOTICE if good else Severity.WARNING
        return (result.sender, severity, f"{verb}-{word}", f"{verb} {word}{': ' if text else ''}{text}{asked_by}")

    def overdue(self, now_s: float) -> Iterator[News]:
        """Who has been silent for too long since the last call."""
        for at, track in enumerate(self._tracks):
            if now_s - track.sent_s < COMMAND_TIMEOUT_S:
                continue
            silent = frozenset(track.command.targets) - track.answers.keys() - track.timed_out
            verb = verb_word(track.command.verb)
            for name in sorted(silent):
                text = f"{verb} not answered within {COMMAND_TIMEOUT_S:.0f} s"
                yield (name, Severity.WARNING, f"{verb}-timed-out", text)
            self._tracks[at] = replace(track, timed_out=track.timed_out | silent)
