"""What the operator looks at in the event log: which entries, and how far back. Pure values."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ground_station.picture import FleetState
from ground_station.views.event_view import EVERYTHING, EventFilter, shown_entries


@dataclass(frozen=True, slots=True)
class EventWindow:
    """How the event log is looked at.

    Attributes
    ----------
    shown
        Which entries are listed.
    scrolled_to
        Number of the newest entry in view; None follows new ones.
    """

    shown: EventFilter = EVERYTHING
    scrolled_to: int | None = None

    def back(self, state: FleetState) -> int:
        """How many listed entries are newer than the newest in view."""
        if self.scrolled_to is None:
            return 0
        listed = shown_entries(state, self.shown)
        newer = 0
        for entry in reversed(listed):
            if entry.number <= self.scrolled_to:
                break
            newer += 1
        return min(newer, max(0, len(listed) - 1))

    def scrolled(self, state: FleetState, entries: int) -> EventWindow:
        """Further back (positive) or forward; at the end it follows new entries again."""
        listed = shown_entries(state, self.shown)
        if not listed:
            return self
        target = max(0, len(listed) - 1 - self.back(state) - entries)
        at_end = target >= len(listed) - 1
        return replace(self, scrolled_to=None if at_end else listed[target].number)

    def showing(self, shown: EventFilter) -> EventWindow:
        """Other entries, the newest first."""
        return EventWindow(shown)
