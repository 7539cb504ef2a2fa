"""The reducer: what is heard, sent and timed goes in, the next immutable `FleetState` comes out. No I/O, no clock.

Example
-------
::

    state = FleetState.initial(plan, "station-1a2b", boot_id, now_s)
    state = fold(state, [Heard(message, now_s), Tick(now_s)])
    state.team_map.coverage
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import msgspec

from ground_station.command_log import CommandLog
from ground_station.conditions import astray_limit_m
from ground_station.inputs import (
    Acknowledged,
    AliveChanged,
    AutopilotHeard,
    CommandSent,
    FleetInput,
    Heard,
    LinkCounted,
    Muted,
    Tick,
)
from ground_station.ledger import SequenceRanges
from ground_station.liveliness import next_condition, transition_text
from ground_station.map_intake import MapIntake
from ground_station.picture import (
    Condition,
    FleetState,
    LogEntry,
    VehiclePicture,
)
from ground_station.samples import trail_with, windowed
from ground_station.text import clean
from ground_station.trouble_log import TroubleLog
from ground_station.vehicle_picture import AutopilotPicture
from vehicle_agent.mission.talk import status_period_s
from vehicle_agent.wire.messages import (
    AnyMessage,
    Claim,
    Command,
    CommandResult,
    Digest,
    Event,
    Landmarks,
    MapDelta,
    Orders,
    Repair,
    Severity,
    Status,
    StreamHeld,
)

MAX_LOG_ENTRIES = 5_000
MAX_SENDERS = 512
EARLIEST_STAMP_MS = 946_684_800_000
"""2000-01-01: a stamp before it is an autopilot that does not know the time yet."""
RATE_WINDOW_MS = 10_000
PACE_WINDOW_S = 10.0


def reduce(state: FleetState, event: FleetInput) -> FleetState:
    """The state after one event."""
    return fold(state, (event,))


def fold(state: FleetState, events: Iterable[FleetInput]) -> FleetState:
    """The state after many events; the map is copied once for the whole batch."""
    draft = _Draft(state)
    for event in events:
        draft.take(event)
    return draft.finish()


def digest_streams(state: FleetState) -> tuple[StreamHeld, ...]:
    """What this station's map is made of, for its `Digest`."""
    return tuple(
        StreamHeld(origin, stream_id, stream.held.contiguous) for (origin, stream_id), stream in state.streams.items()
    )


class _Draft:
    """The next state in the making: mutable copies of what a batch may change."""

    def __init__(self, state: FleetState) -> None:
        self._state = state
        self._now_s = state.now_s
        self._vehicles = {vehicle.name: vehicle for vehicle in state.vehicles}
        self._maps = MapIntake(state)
        self._seen = dict(state.seen)
        self._log: list[LogEntry] = []
        self._commands = CommandLog(state)
        self._counters = state.counters
        self._started_ms = state.started_ms
        self._newest_ms = state.newest_ms
        self._pace = state.pace_samples
        self._troubles = TroubleLog(state.troubles, state.muted)

    def take(self, event: FleetInput) -> None:
        match event:
            case Heard():
                self._hear(event.message, event.arrival_s)
            case Tick():
                self._tick(event.now_s)
            case AliveChanged():
                self._alive(event)
            case CommandSent():
                self._write(*self._commands.sent(event))
            case AutopilotHeard():
                self._autopilot(event)
            case LinkCounted():
                self._counters = replace(
                    self._counters, undecodable=event.undecodable, overflowed=event.overflowed
                )  # fmt: skip
            case Acknowledged():
                self._troubles.acknowledge(event.vehicle, event.kind)
            case Muted():
                self._troubles.mute(event.vehicle, event.kind, event.muted)

    def finish(self) -> FleetState:
        state = self._state
        team_map, landmarks = self._maps.maps()
        if self._maps.earliest_ms is not None:
            self._note_stamp(self._maps.earliest_ms)
        counters = replace(
            self._counters,
            foreign=self._counters.foreign + self._maps.foreign,
            malformed=self._counters.malformed + self._maps.malformed,
        )
        return replace(
            state,
            now_s=self._now_s,
            vehicles=tuple(self._vehicles.values()),
            team_map=team_map,
            landmarks=landmarks,
            streams=self._maps.streams,
            seen=self._seen,
            log=(*state.log, *self._log)[-MAX_LOG_ENTRIES:] if self._log else state.log,
            log_total=state.log_total + len(self._log),
            commands=self._commands.tracks,
            counters=counters,
            started_ms=self._started_ms,
            newest_ms=self._newest_ms,
            pace_samples=self._pace,
            troubles=self._troubles.troubles,
            muted=self._troubles.muted,
        )

    # -- messages -------------------------------------------------------------------------------------------------

    def _hear(self, message: AnyMessage, arrival_s: float) -> None:
        vehicle = self._vehicles.get(message.sender)
        if isinstance(message, Command):
            if message.sender != self._state.station and self._is_new(message):
                self._write(*self._commands.overheard(message), message.stamp_ms)
            return
        if vehicle is None:
            self._counters = replace(self._counters, foreign=self._counters.foreign + 1)
            return
        if not self._is_new(message):
            self._counters = replace(self._counters, repeated=self._counters.repeated + 1)
            return
        self._note_stamp(message.stamp_ms)
        match message:
            case Status():
                self._status(vehicle, message, arrival_s)
            case MapDelta():
                self._maps.take_records((message.record,))
            case Repair():
                self._maps.take_records(message.records)
            case Digest():
                self._maps.take_digest(message)
            case Landmarks():
                self._maps.take_landmarks(message)
            case Claim():
                self._claim(vehicle, message)
            case Event():
                self._write(message.sender, message.severity, message.code, message.text, message.stamp_ms)
            case CommandResult():
                self._write(*self._commands.answered(message), message.stamp_ms)
            case Orders():
                self._orders(vehicle, message)
            case _:
                self._counters = replace(self._counters, foreign=self._counters.foreign + 1)

    def _is_new(self, message: AnyMessage) -> bool:
        life = (message.sender, message.boot_id)
        seen = self._seen.get(life, SequenceRanges())
        if message.sequence in seen:
            return False
        self._seen[life] = seen.with_number(message.sequence)
        if len(self._seen) > MAX_SENDERS:
            del self._seen[next(iter(self._seen))]
        return True

    def _note_stamp(self, stamp_ms: int) -> None:
        if stamp_ms < EARLIEST_STAMP_MS:
            return
        self._started_ms = min(self._started_ms or stamp_ms, stamp_ms)
        self._newest_ms = max(self._newest_ms, stamp_ms)

    def _status(self, vehicle: VehiclePicture, status: Status, arrival_s: float) -> None:
        last = vehicle.status
        past_boots = vehicle.past_boots
        samples = vehicle.sent_samples
        claim = vehicle.claim
        if status.boot_id in past_boots:
            self._put(replace(vehicle, evidence=vehicle.evidence.with_rival(arrival_s)))
            return
        if last is not None and last.boot_id == status.boot_id and status.sequence < last.sequence:
            return
        if last is not None and last.boot_id != status.boot_id:
            past_boots = (*past_boots, last.boot_id)[-16:]
            samples, claim = (), None
            vehicle = replace(vehicle, orders=None)
            self._write(vehicle.name, Severity.WARNING, "agent-restarted", "its agent was started anew")
        elif last is None:
            self._write(vehicle.name, Severity.INFO, "heard", "is heard on the link")
        astray_m = astray_limit_m(self._state.plan, vehicle.index)
        status = msgspec.structs.replace(status, mode=clean(status.mode, 16), why=clean(status.why))
        self._put(
            replace(
                vehicle,
                status=status,
                arrival_s=arrival_s,
                past_boots=past_boots,
                claim=claim,
                sent_samples=windowed(samples, (status.stamp_ms, status.bytes_sent), RATE_WINDOW_MS),
                trail_en_m=trail_with(vehicle.trail_en_m, status, 0.5 * self._state.plan.grid.cell_m),
                evidence=vehicle.evidence.after(status, arrival_s, astray_m),
            )
        )

    def _claim(self, vehicle: VehiclePicture, claim: Claim) -> None:
        last = vehicle.claim
        overtaken = last is not None and last.boot_id == claim.boot_id and last.sequence > claim.sequence
        if claim.boot_id not in vehicle.past_boots and not overtaken:
            self._put(replace(vehicle, claim=claim))

    def _orders(self, vehicle: VehiclePicture, orders: Orders) -> None:
        last = vehicle.orders
        overtaken = last is not None and last.boot_id == orders.boot_id and last.sequence > orders.sequence
        if orders.boot_id not in vehicle.past_boots and not overtaken:
            self._put(replace(vehicle, orders=orders))

    # -- the station's own findings -------------------------------------------------------------------------------

    def _alive(self, event: AliveChanged) -> None:
        vehicle = self._vehicles.get(event.participant)
        if vehicle is not None:
            self._put(replace(vehicle, alive=event.alive, alive_changed_s=event.arrival_s))

    def _autopilot(self, event: AutopilotHeard) -> None:
        for vehicle in self._vehicles.values():
            if self._state.plan.system_id(vehicle.index) == event.system_id:
                known = vehicle.autopilot.sources if vehicle.autopilot is not None else ()
                source = clean(event.source, 48)
                others = tuple(one for one in known if one[0] != source)[-3:]
                sources = (*others, (source, event.arrival_s))
                picture = AutopilotPicture(event.arrival_s, event.armed, event.in_failsafe, sources)
                self._put(replace(vehicle, autopilot=picture))

    def _tick(self, now_s: float) -> None:
        self._now_s = max(self._now_s, now_s)
        # Statuses only: events and repairs also tell of long ago, and a jump to now would look like haste.
        stamp_ms = max((vehicle.status.stamp_ms for vehicle in self._vehicles.values() if vehicle.status), default=0)
        if stamp_ms and (not self._pace or stamp_ms > self._pace[-1][1]):
            self._pace = windowed(self._pace, (self._now_s, stamp_ms), PACE_WINDOW_S)
        pace = replace(self._state, pace_samples=self._pace).speedup or 1.0
        for vehicle in self._vehicles.values():
            condition = next_condition(vehicle, self._now_s, pace, status_period_s(self._state.plan))
            if condition is vehicle.condition:
                continue
            found = transition_text(vehicle, condition, self._now_s)
            if found is not None:
                self._write(vehicle.name, *found)
            quiet = {vehicle.condition, condition} == {Condition.LIVE, Condition.SUSPECT}
            since_s = vehicle.condition_since_s if quiet else self._now_s
            self._put(replace(vehicle, condition=condition, condition_since_s=since_s))
        vehicles = tuple(self._vehicles.values())
        for name, severity, code, text in self._troubles.look(vehicles, self._state.plan, self._now_s, pace):
            self._write(name, severity, code, text)
        for news in self._commands.overdue(self._now_s):
            self._write(*news)

    def _put(self, vehicle: VehiclePicture) -> None:
        self._vehicles[vehicle.name] = vehicle

    def _write(self, source: str, severity: Severity, code: str, text: str, stamp_ms: int | None = None) -> None:
        number = self._state.log_total + len(self._log)
        stamp_ms = self._newest_ms if stamp_ms is None else stamp_ms
        self._log.append(LogEntry(number, stamp_ms, clean(source, 31), severity, clean(code, 32), clean(text)))
