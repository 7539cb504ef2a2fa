"""The event log, newest at the bottom, long texts wrapped."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ground_station.picture import FleetState, LogEntry
from ground_station.text import duration
from ground_station.views import palette
from ground_station.views.ink import Line, Look, line_of, wrapped
from vehicle_agent.wire.messages import Severity


@dataclass(frozen=True, slots=True)
class EventFilter:
    """Which entries are shown.

    Attributes
    ----------
    vehicle
        Only what this vehicle says, or what the station found about it; empty: everybody.
    mildest
        Nothing milder than this.
    """

    vehicle: str = ""
    mildest: Severity = Severity.INFO

    def passes(self, entry: LogEntry) -> bool:
        return entry.severity <= self.mildest and self.vehicle in ("", entry.source)

    def with_next_severity(self) -> EventFilter:
        order = (Severity.INFO, Severity.NOTICE, Severity.WARNING, Severity.ERROR)
        return replace(self, mildest=order[(order.index(self.mildest) + 1) % len(order)])

    @property
    def words(self) -> str:
        """What is left out, for the heading; empty when nothing is."""
        severity = {Severity.NOTICE: "notices", Severity.WARNING: "warnings", Severity.ERROR: "errors"}
        return " ".join(word for word in (severity.get(self.mildest, ""), self.vehicle) if word)


EVERYTHING = EventFilter()


def shown_entries(state: FleetState, shown: EventFilter) -> tuple[LogEntry, ...]:
    """The log's entries that pass a filter, oldest first."""
    return state.log if shown == EVERYTHING else tuple(entry for entry in state.log if shown.passes(entry))


def event_lines(
    state: FleetState, width: int, height: int, look: Look, back: int = 0, shown: EventFilter = EVERYTHING
) -> list[Line]:
    """The last lines of the log.

    Parameters
    ----------
    back
        How many of the shown entries from the newest the view is scrolled back.
    """
    quiet = look.ink(palette.QUIET)
    room = height - 1
    entries = shown_entries(state, shown)
    entries = entries[: len(entries) - back] if back else entries
    lines: list[Line] = []
    for entry in reversed(entries):
        lines[:0] = _entry_lines(entry, state, width, look)
        if len(lines) >= room:
            break
    only = f" ({shown.words} only)" if shown.words else ""
    heading = f"events {state.log_total}{only}" + (f", {back} newer below" if back else "")
    bad = state.counters.bad
    head = line_of((heading, quiet), (f"  {bad} bad messages dropped" if bad else "", look.ink(palette.WARN)))
    return [head, *lines[max(0, len(lines) - room) :]]


def _entry_lines(entry: LogEntry, state: FleetState, width: int, look: Look) -> list[Line]:
    unicode_mark, ascii_mark, colour = palette.severity_mark(entry.severity)
    names = {vehicle.name: vehicle.index for vehicle in state.vehicles}
    elapsed_s = max(0.0, (entry.stamp_ms - state.started_ms) / 1_000) if entry.stamp_ms else 0.0
    stamp = f"{duration(elapsed_s)} "
    source = look.ink(palette.vehicle_colour(names[entry.source])) if entry.source in names else look.ink(palette.QUIET)
    indent = len(stamp) + 2
    words = look.ink() if colour == palette.QUIET else look.ink(colour)
    first, *rest = wrapped(entry.text or entry.code, max(8, width - indent), len(entry.source) + 1)
    head = line_of(
        (stamp, look.ink(palette.QUIET)),
        (look.glyph(unicode_mark, ascii_mark) + " ", look.ink(colour)),
        (entry.source + " ", source),
        (first, words),
    )
    return [head, *(line_of((" " * indent + piece, words)) for piece in rest)]
