"""The whole agent of one vehicle as a function of time and messages: no I/O, no clock, no threads."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vehicle_agent.behaviour.command_desk import CommandDesk
from vehicle_agent.behaviour.flight import Flight
from vehicle_agent.behaviour.guide import Guide
from vehicle_agent.behaviour.knowledge import Knowledge
from vehicle_agent.behaviour.map_exchange import encode_record
from vehicle_agent.behaviour.order_book import OrderBook
from vehicle_agent.behaviour.outfit import outfit
from vehicle_agent.behaviour.plausible import plausible
from vehicle_agent.behaviour.rhythm import Rhythm
from vehicle_agent.behaviour.shared_map import SharedMap
from vehicle_agent.behaviour.status_report import Figures, status_fields
from vehicle_agent.behaviour.voice import Voice
from vehicle_agent.domain.team_map import TeamMap
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.ports import Inbox, Outbox, VehicleState
from vehicle_agent.wire.keys import TOPIC_BY_NAME
from vehicle_agent.wire.messages import (
    AnyMessage,
    Claim,
    Command,
    CommandResult,
    Digest,
    MapDelta,
    Outcome,
    Repair,
    Severity,
    Stage,
    Status,
)

HEAR_FIRST_S = 10.0
"""A restarted agent adds nothing to its stream before teammates could return what its journal lost of it."""


class VehicleAgent:
    """Decides for one vehicle.

    Parameters
    ----------
    plan
        The mission; the vehicle's own terrain is not in it.
    index
        Team index of this vehicle.
    boot_id
        Drawn anew at every start.
    rng
        This vehicle's generator: `default_rng(SeedSequence(mission.seed, spawn_key=(index,)))`.
    journal_records
        What an earlier run of this agent journalled, to resume from.
    """

    def __init__(
        self,
        plan: MissionPlan,
        index: int,
        boot_id: int,
        rng: np.random.Generator,
        journal_records: Iterable[bytes] = (),
    ) -> None:
        vehicle = plan.mission.vehicles[index]
        shared, navigator = self._outfit(plan, index, rng)
        self.name = vehicle.name
        self._voice = Voice(vehicle.name, boot_id)
        self._orders = OrderBook()
        self._knowledge = Knowledge(plan, index, shared, boot_id, journal_records)
        self._status_rhythm = Rhythm(TOPIC_BY_NAME["status"].period_s or 1.0)
        self._map_rhythm = Rhythm(TOPIC_BY_NAME["map"].period_s or 2.0)
        self._digest_rhythm = Rhythm(TOPIC_BY_NAME["digest"].period_s or 5.0)
        self._flight = Flight(plan, index, navigator, self._knowledge, self._voice, self._orders, self._status_rhythm)
        self._commands = CommandDesk(vehicle.name)
        self._now_s = 0.0
        self._began_ms: int | None = None
        self._state: VehicleState | None = None
        self._makes_sense = True
        self._said_status_ms, self._answer_after_ms = 0, -1
        self.bytes_sent = 0
        self.messages_dropped = 0

    def _outfit(self, plan: MissionPlan, index: int, rng: np.random.Generator) -> tuple[SharedMap, Guide]:
        """The kind of map that the mission needs, and who leads the vehicle through it."""
        return outfit(plan, index, rng)

    @property
    def stage(self) -> Stage:
        return self._flight.stage

    @property
    def map(self) -> TeamMap:
        """Everything that this vehicle measured or was told."""
        return self._knowledge.map

    @property
    def finished(self) -> bool:
        """Landed and disarmed after its mission, or refused to fly."""
        return self.stage in (Stage.DONE, Stage.REFUSED)

    @property
    def known_fraction(self) -> float:
        """Share of the area's cells on this vehicle's map."""
        return self._knowledge.known_fraction(self._flight.standing.area_cells)

    @property
    def first_seen_cells(self) -> float:
        """J_E of this vehicle (Renzaglia eq. 5)."""
        return self._knowledge.first_seen_cells

    def step(self, now_s: float, inbox: Inbox) -> Outbox:
        """Take in what arrived, decide, and return what is to be done.

        Parameters
        ----------
        now_s
            The vehicle's own time, Unix seconds; it never runs backwards.
        """
        self._now_s = max(self._now_s, now_s)
        self._take_state(inbox.state)
        self._voice.stamp_ms = self._state.stamp_ms if self._state else int(self._now_s * 1000)
        for result in inbox.results:
            self._flight.hear(result)
        for scan in inbox.scans:
            self._knowledge.observe(scan)
        for message in inbox.messages:
            self._hear(message)
        for text in inbox.texts:
            if text.severity <= Severity.WARNING:
                self._voice.event(Severity(max(text.severity, Severity.CRITICAL)), "autopilot", text.text)
        for name in self._knowledge.team.newly_lost(self._now_s):
            self._voice.event(Severity.WARNING, "teammate-lost", f"{name} is silent: its goals are free again")
        if self._state is not None:
            self._flight.step(self._now_s, self._state)
        journal = self._report()
        return Outbox(journal, self._orders.take(), self._voice.take())

    def _take_state(self, told: VehicleState | None) -> None:
        if told is None:
            return
        state = plausible(told)
        if (state is not None) != self._makes_sense:
            self._makes_sense = state is not None
            code, text = ("position-back", "the autopilot tells its position again")
            if state is None:
                code, text = ("no-position", "the autopilot tells no usable position: going by the last one")
            self._voice.event(Severity.WARNING, code, text)
        if state is not None and self._began_ms is None:
            self._began_ms = state.stamp_ms
            if self._knowledge.exchange.own_stream.held:
                self._map_rhythm.wait_until(self._now_s + HEAR_FIRST_S)
        self._state = state or self._state

    def _hear(self, message: AnyMessage) -> None:
        if message.sender == self.name:  # an echo, or somebody who took this name
            return
        match message:
            case Status():
                if self._knowledge.team.hear_status(message, self._now_s):
                    self._voice.event(Severity.NOTICE, "teammate-back", f"{message.sender} is heard again")
                if message.next_end_cm is not None:
                    self._owe_answer(message)
            case Claim():
                self._knowledge.team.hear_claim(message)
            case MapDelta():
                self._knowledge.receive((message.record,))
            case Repair():
                self._knowledge.receive(message.records, repaired_at_s=self._now_s)
            case Digest():
                if records := self._knowledge.repair_for(message, self._now_s):
                    self._voice.say(Repair, records=records)
            case Command():
                self._obey(message)
            case _:
                pass

    def _owe_answer(self, status: Status) -> None:
        """A teammate waits for this vehicle's word from after it told its intent, if it may cross what is flown here.

        Said or not, the next regular status is such a word: an answer only comes sooner.
        """
        if self._state is None:
            return
        leg = self._flight.navigator.leg
        here = self._state.position_enu_m
        if self._knowledge.is_awaited(status.sender, (here, leg.end_enu_m if leg else here), self._now_s):
            self._answer_after_ms = max(self._answer_after_ms, status.stamp_ms - status.next_told_ms)

    def _obey(self, command: Command) -> None:
        answer = self._commands.judge(command, self.stage, self._began_ms or 0)
        if answer is None:
            return
        outcome, reason = answer
        if outcome is Outcome.ACCEPTED and (trouble := self._flight.trouble(command, self._state)):
            outcome, reason = Outcome.REFUSED, trouble
        self._voice.say(
            CommandResult,
            station=command.sender,
            station_boot_id=command.boot_id,
            command_id=command.command_id,
            verb=command.verb,
            outcome=outcome,
            text=reason,
        )
        if outcome is Outcome.ACCEPTED and self._state is not None:
            self._flight.obey(command, self._now_s, self._state)

    def _report(self) -> list[bytes]:
        """Say what is due; returns what the journal must keep before it is said."""
        journal = []
        if self._map_rhythm.is_due(self._now_s) and (record := self._knowledge.exchange.next_record()) is not None:
            journal.append(encode_record(record))
            self._voice.say(MapDelta, record=record)
        if self._digest_rhythm.is_due(self._now_s):
            self._voice.say(Digest, streams=self._knowledge.exchange.digest())
        if self._said_status_ms <= self._answer_after_ms < self._voice.stamp_ms:
            self._status_rhythm.at_once()
        if self._state is not None and self._status_rhythm.is_due(self._now_s):
            self._say_status(self._state)
        return journal

    def _say_status(self, state: VehicleState) -> None:
        flight = self._flight
        figures = Figures(
            self.known_fraction,
            self.first_seen_cells,
            self.bytes_sent,
            self.messages_dropped + self._knowledge.exchange.refused,
        )
        fields = status_fields(
            flight.stage,
            state,
            flight.navigator,
            flight.home_enu_m(state),
            flight.take_off_height_m,
            flight.return_height.height_m,
            figures,
            flight.intent,
        )
        self._said_status_ms = self._voice.stamp_ms
        self._voice.say(Status, **fields)
