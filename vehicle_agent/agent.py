"""The whole agent of one vehicle as a function of time and messages: no I/O, no clock, no threads."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from vehicle_agent.behaviour.command_desk import CommandDesk
from vehicle_agent.behaviour.energy import EnergyWatch
from vehicle_agent.behaviour.map_exchange import MapExchange, encode_record
from vehicle_agent.behaviour.navigator import Navigator, Surroundings
from vehicle_agent.behaviour.preflight import (
    Checklist,
    parameters_before_arming,
    return_altitude,
    return_height_m,
)
from vehicle_agent.behaviour.rhythm import Rhythm
from vehicle_agent.behaviour.team_picture import TeamPicture
from vehicle_agent.behaviour.units import to_centimetres
from vehicle_agent.behaviour.voice import Voice
from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.frames import Point
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.planning.choose import make_planner
from vehicle_agent.planning.interface import Finished
from vehicle_agent.planning.travel import way_length_m
from vehicle_agent.ports import (
    Action,
    ActionResult,
    Arm,
    FlightMode,
    GoTo,
    Hold,
    Inbox,
    Land,
    Landed,
    Order,
    Outbox,
    TakeOff,
    VehicleState,
)
from vehicle_agent.wire.keys import TOPIC_BY_NAME
from vehicle_agent.wire.messages import (
    Claim,
    Command,
    CommandResult,
    DeltaRecord,
    Digest,
    MapDelta,
    Outcome,
    Repair,
    Severity,
    Stage,
    Status,
    Verb,
)

RETRY_S = 3.0
YIELD_AFTER_S = 3.0
"""A mode that nobody here ordered must last so long before the agent gives way to it."""
RETURN_ALTITUDE_STEP_M = 10.0
FLYING = (Stage.WORKING, Stage.HOLDING, Stage.RETURNING)


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
        mission, vehicle = plan.mission, plan.mission.vehicles[index]
        self._plan, self._index, self._vehicle = plan, index, vehicle
        self._voice = Voice(vehicle.name, boot_id)
        self._exchange = MapExchange(plan.grid, plan.vehicle_names, index, boot_id, journal_records)
        self._team = TeamPicture(vehicle.name, plan.vehicle_names, mission.safety.teammate_silence_s)
        planner = make_planner(mission.task.planner, plan.grid, vehicle.sensor.range_m, mission.task.step_m, rng)
        self._navigator = Navigator(plan, index, planner)
        self._commands = CommandDesk(vehicle.name)
        self._energy = EnergyWatch(mission.stop.battery_reserve)
        self._checklist = Checklist(parameters_before_arming(plan, index))
        self._area_cell_count = int(plan.area_cells.sum())
        self._out = Outbox()
        self._now_s = 0.0
        self._state: VehicleState | None = None
        self._next_action_id = 1
        self._status_rhythm = Rhythm(TOPIC_BY_NAME["status"].period_s or 1.0)
        self._map_rhythm = Rhythm(TOPIC_BY_NAME["map"].period_s or 2.0)
        self._digest_rhythm = Rhythm(TOPIC_BY_NAME["digest"].period_s or 5.0)
        self._retry_rhythm = Rhythm(RETRY_S)
        self._return_altitude_rhythm = Rhythm(RETRY_S)
        self._map_version = 0
        self._took_off_at_s: float | None = None
        self._foreign_mode_since_s: float | None = None
        self._return_height_m = return_height_m(plan, index, 0.0, 0.0)
        self._claimed: Point | None = None
        self._last_arming_refusal = ""
        self.stage = Stage.CONNECTING
        self.bytes_sent = 0
        self.messages_dropped = 0

    @property
    def name(self) -> str:
        return self._vehicle.name

    @property
    def map(self) -> ElevationMap:
        """Everything that this vehicle measured or was told."""
        return self._exchange.team_map

    @property
    def finished(self) -> bool:
        """Landed and disarmed after its mission, or refused to fly."""
        return self.stage in (Stage.DONE, Stage.REFUSED)

    @property
    def known_fraction(self) -> float:
        """Share of the area's cells on this vehicle's map."""
        return float((self.map.observed & self._plan.area_cells).sum()) / self._area_cell_count

    @property
    def first_seen_cells(self) -> float:
        """J_E of this vehicle (Renzaglia eq. 5)."""
        return self.map.first_observer_share(self._index, self._plan.area_cells)

    def step(self, now_s: float, inbox: Inbox) -> Outbox:
        """Take in what arrived, decide, and return what is to be done.

        Parameters
        ----------
        now_s
            The vehicle's own time, Unix seconds; it never runs backwards.
        """
        self._out = Outbox()
        self._now_s = max(now_s, self._now_s)
        self._state = inbox.state or self._state
        self._voice.stamp_ms = self._state.stamp_ms if self._state else int(self._now_s * 1000)
        for result in inbox.results:
            self._hear_result(result)
        for scan in inbox.scans:
            self._map_version += self._exchange.observe(scan.cells)
        for message in inbox.messages:
            self._hear(message)
        for text in inbox.texts:
            if text.severity <= Severity.WARNING:
                self._voice.event(Severity(max(text.severity, Severity.CRITICAL)), "autopilot", text.text)
        for name in self._team.newly_lost(self._now_s):
            self._voice.event(Severity.WARNING, "teammate-lost", f"{name} is silent: its goals are free again")
        if self._state is not None:
            self._act(self._state)
        self._report()
        self._out.messages = self._voice.take()
        return self._out

    def _act(self, state: VehicleState) -> None:
        if self.stage in FLYING or self.stage is Stage.YIELDED:
            self._watch_mode(state)
        match self.stage:
            case Stage.CONNECTING:
                self._connect(state)
            case Stage.CONFIGURING:
                self._configure(state)
            case Stage.ARMING:
                self._arm(state)
            case Stage.TAKING_OFF:
                self._take_off(state)
            case Stage.WORKING:
                self._work(state)
            case Stage.RETURNING:
                self._return(state)
            case Stage.LANDING:
                self._land(state)
            case _:
                pass
        if self.stage in FLYING:
            self._energy.note(self._now_s, state.battery_fraction)
            self._keep_return_altitude(state)

    def _connect(self, state: VehicleState) -> None:
        if state.rival_controller:
            own_id = self._plan.controller_system_id(self._index)
            self._refuse(
                f"another program speaks on this vehicle with system id {own_id}: stop it, or its heartbeats hide "
                "this agent's death from the autopilot"
            )
        elif state.home_enu_m is not None and state.armed and state.landed is Landed.IN_AIR:
            self._took_off_at_s = self._now_s
            self._enter(Stage.WORKING, "resumed", "resumed in the air from the journal")
        elif state.home_enu_m is not None or state.ready_to_arm:
            self._enter(Stage.CONFIGURING, "connected", "autopilot found")

    def _configure(self, state: VehicleState) -> None:
        if self._checklist.failed:
            self._refuse(self._checklist.failed)
        elif self._checklist.done:
            self._enter(Stage.ARMING, "configured", "the autopilot now watches this agent")
        elif (order := self._checklist.next_order()) is not None:
            self._checklist.submitted(self._order(order))

    def _arm(self, state: VehicleState) -> None:
        if state.rival_controller:
            self.stage = Stage.CONNECTING
            self._connect(state)
        elif state.armed and state.mode is FlightMode.GUIDED:
            self._enter(Stage.TAKING_OFF, "armed", "armed")
            self._retry_rhythm.at_once()
        elif state.ready_to_arm and state.home_enu_m is not None and self._retry_rhythm.is_due(self._now_s):
            self._order(Arm())

    def _take_off(self, state: VehicleState) -> None:
        assert state.home_enu_m is not None
        height_m = self._vehicle.min_above_terrain_m * 1.1
        climbed_m = state.position_enu_m[2] - state.home_enu_m[2]
        if climbed_m >= 0.95 * height_m:
            self._took_off_at_s = self._now_s
            self._enter(Stage.WORKING, "took-off", f"airborne at {climbed_m:.0f} m above home")
        elif not state.armed:
            self._enter(Stage.ARMING, "disarmed", "disarmed before take-off; arming again", Severity.WARNING)
        elif climbed_m < 0.2 * height_m and self._retry_rhythm.is_due(self._now_s):
            self._order(TakeOff(height_m))

    def _work(self, state: VehicleState) -> None:
        reason = self._reason_to_return(state)
        if reason is None:
            target = self._navigator.work(self._around(state))
            if isinstance(target, Finished):
                reason = target.why
            else:
                self._fly(target)
        if reason is not None:
            self._go_home(state, reason)

    def _reason_to_return(self, state: VehicleState) -> str | None:
        stop = self._plan.mission.stop
        known = self.known_fraction
        if known >= stop.observed_fraction:
            return f"{100 * known:.1f} % of the area is known"
        if self._took_off_at_s is not None and self._now_s - self._took_off_at_s > stop.time_limit_s:
            return f"time limit of {stop.time_limit_s:.0f} s reached"
        if state.home_enu_m is not None:
            way_s = way_length_m(state.position_enu_m, state.home_enu_m[:2]) / self._vehicle.speed_m_s
            if self._energy.must_return(state.battery_fraction, way_s):
                return f"battery at {100 * (state.battery_fraction or 0.0):.0f} %, home is {way_s:.0f} s away"
        return None

    def _go_home(self, state: VehicleState, reason: str) -> None:
        self._enter(Stage.RETURNING, "returning", reason)
        self._release_claim()
        self._fly(self._navigator.stay(self._around(state), reason))

    def _return(self, state: VehicleState) -> None:
        home = state.home_enu_m or self._start_enu_m()
        if self._navigator.is_over_home(state, home):
            self._enter(Stage.LANDING, "landing", "over home")
            self._retry_rhythm.at_once()
            self._land(state)
        else:
            self._fly(self._navigator.go_home(self._around(state), home))

    def _land(self, state: VehicleState) -> None:
        if not state.armed:
            self._navigator.forget("on the ground, disarmed")
            self._enter(Stage.DONE, "landed", "landed and disarmed")
        elif state.mode is not FlightMode.LAND and self._retry_rhythm.is_due(self._now_s):
            self._order(Land())

    def _watch_mode(self, state: VehicleState) -> None:
        """Give way to a pilot or a failsafe; take up the work again when the vehicle is handed back."""
        if not state.armed:
            self._navigator.forget("disarmed")
            self._release_claim()
            self._enter(Stage.DONE, "landed", "landed and disarmed by its autopilot", Severity.NOTICE)
            return
        own = state.mode is FlightMode.GUIDED or (self.stage is Stage.HOLDING and state.mode is FlightMode.HOLD)
        if own:
            self._foreign_mode_since_s = None
            if self.stage is Stage.YIELDED:
                self._enter(Stage.WORKING, "handed-back", "guided again: back to work")
        elif self.stage is not Stage.YIELDED:
            if self._foreign_mode_since_s is None:
                self._foreign_mode_since_s = self._now_s
            elif self._now_s - self._foreign_mode_since_s > YIELD_AFTER_S:
                self._navigator.forget(f"mode {state.mode.value}, not ordered by this agent")
                self._release_claim()
                self._enter(Stage.YIELDED, "yielded", self._navigator.why, Severity.WARNING)

    def _hear(self, message: object) -> None:
        match message:
            case Status():
                if self._team.hear_status(message, self._now_s):
                    self._voice.event(Severity.NOTICE, "teammate-back", f"{message.sender} is heard again")
            case Claim():
                self._team.hear_claim(message)
            case MapDelta():
                self._receive((message.record,))
            case Repair():
                self._receive(message.records)
            case Digest():
                self._repair(message)
            case Command():
                self._obey(message)
            case _:
                pass

    def _receive(self, records: Iterable[DeltaRecord]) -> None:
        self._exchange.receive(records)
        self._map_version += 1

    def _repair(self, digest: Digest) -> None:
        names = self._plan.vehicle_names
        living = {self._vehicle.name, *self._team.living()}
        first_in_line = min((n for n in living if n != digest.sender), key=names.index) == self._vehicle.name
        responsible = {self._vehicle.name}
        if first_in_line:
            responsible |= set(names) - living
        records = self._exchange.repair_for(digest, frozenset(responsible), self._now_s)
        if records:
            self._voice.say(Repair, records=records)

    def _obey(self, command: Command) -> None:
        answer = self._commands.judge(command, self.stage)
        if answer is None:
            return
        outcome, reason = answer
        self._voice.say(
            CommandResult,
            station=command.sender,
            station_boot_id=command.boot_id,
            command_id=command.command_id,
            verb=command.verb,
            outcome=outcome,
            text=reason,
        )
        if outcome is not Outcome.ACCEPTED or self._state is None:
            return
        match command.verb:
            case Verb.HOLD:
                self._release_claim()
                self._navigator.forget("held by the operator")
                self._enter(Stage.HOLDING, "holding", "held by the operator")
                self._order(Hold())
            case Verb.RESUME:
                self._foreign_mode_since_s = None
                self._enter(Stage.WORKING, "resumed", "resumed by the operator")
                self._fly(self._navigator.stay(self._around(self._state), "resumed"))
            case Verb.RETURN:
                self._go_home(self._state, "called home by the operator")
            case Verb.LAND:
                self._release_claim()
                self._navigator.forget("landing here, ordered by the operator")
                self._enter(Stage.LANDING, "landing", "landing here, ordered by the operator")
                self._order(Land())

    def _around(self, state: VehicleState) -> Surroundings:
        return Surroundings(
            self._now_s,
            state,
            self.map,
            self._map_version,
            self._team.teammates(),
            self._team.reservations(self._now_s),
            self.first_seen_cells,
        )

    def _fly(self, target: Point | None) -> None:
        if target is None:
            return
        self._order(GoTo(target))
        waypoint = self._navigator.waypoint
        if waypoint is not None and waypoint.goal_enu_m is not None:
            if self._claimed is None or math.dist(self._claimed, waypoint.goal_enu_m) > 1.0:
                self._claimed = waypoint.goal_enu_m
                self._voice.say(
                    Claim, active=True, goal_cm=to_centimetres(self._claimed), cost_m=round(waypoint.goal_cost_m)
                )
        else:
            self._release_claim()
        self._status_rhythm.at_once()

    def _release_claim(self) -> None:
        if self._claimed is not None:
            self._voice.say(Claim, active=False, goal_cm=to_centimetres(self._claimed), cost_m=0)
            self._claimed = None

    def _keep_return_altitude(self, state: VehicleState) -> None:
        """Keep the failsafe's way home above all ground that is known by now."""
        if state.home_enu_m is None or not self._return_altitude_rhythm.is_due(self._now_s):
            return
        highest_dm = np.max(self.map.elevation_dm, where=self.map.observed, initial=-(10**6))
        wanted_m = return_height_m(self._plan, self._index, float(highest_dm) * 0.1, state.home_enu_m[2])
        if wanted_m > self._return_height_m:
            self._return_height_m = wanted_m + RETURN_ALTITUDE_STEP_M
            self._order(return_altitude(self._return_height_m))

    def _report(self) -> None:
        if self._map_rhythm.is_due(self._now_s) and (record := self._exchange.next_record()) is not None:
            self._out.journal.append(encode_record(record))
            self._voice.say(MapDelta, record=record)
        if self._digest_rhythm.is_due(self._now_s):
            self._voice.say(Digest, streams=self._exchange.digest())
        if self._state is not None and self._status_rhythm.is_due(self._now_s):
            self._say_status(self._state)

    def _say_status(self, state: VehicleState) -> None:
        navigator = self._navigator
        home = state.home_enu_m or self._start_enu_m()
        leg_end = navigator.leg.end_enu_m if navigator.leg else state.position_enu_m
        if self.stage in (Stage.TAKING_OFF, Stage.LANDING):
            height_m = self._vehicle.min_above_terrain_m * 1.1
            leg_end = home if self.stage is Stage.LANDING else (home[0], home[1], home[2] + height_m)
        why = navigator.why if self.stage in FLYING or self.stage is Stage.YIELDED else self.stage.name.lower()
        self._voice.say(
            Status,
            stage=self.stage,
            mode=state.mode.value,
            armed=state.armed,
            position_cm=to_centimetres(state.position_enu_m),
            velocity_cm_s=to_centimetres(state.velocity_enu_m_s),
            heading_deg=round(state.heading_deg) % 360,
            battery_permille=-1 if state.battery_fraction is None else round(1000 * min(state.battery_fraction, 1.0)),
            leg_end_cm=to_centimetres(leg_end),
            home_cm=to_centimetres(home),
            known_permille=int(1000 * self.known_fraction),
            first_seen_cells=round(self.first_seen_cells),
            bytes_sent=self.bytes_sent,
            messages_dropped=self.messages_dropped + self._exchange.refused,
            why=why[:160],
            path_cm=tuple(to_centimetres(p) for p in navigator.waypoint.route_enu_m) if navigator.waypoint else (),
            return_up_cm=to_centimetres((0.0, 0.0, home[2] + self._return_height_m))[2],
        )

    def _hear_result(self, result: ActionResult) -> None:
        self._checklist.hear(result)
        if self.stage is Stage.ARMING and not result.accepted and result.text != self._last_arming_refusal:
            self._last_arming_refusal = result.text
            self._voice.event(Severity.NOTICE, "arming-refused", result.text)

    def _order(self, order: Order) -> int:
        action_id = self._next_action_id
        self._next_action_id += 1
        self._out.actions.append(Action(action_id, order))
        return action_id

    def _enter(self, stage: Stage, code: str, text: str, severity: Severity = Severity.INFO) -> None:
        self.stage = stage
        self._voice.event(severity, code, text)
        self._status_rhythm.at_once()

    def _refuse(self, why: str) -> None:
        self._navigator.forget(why)
        self._enter(Stage.REFUSED, "refused", why, Severity.ERROR)

    def _start_enu_m(self) -> Point:
        start = self._vehicle.start_enu_m
        up_m = start[2] if len(start) == 3 else self._state.position_enu_m[2] if self._state else 0.0
        return (start[0], start[1], up_m)
