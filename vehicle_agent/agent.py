"""The whole agent of one vehicle as a function of time and messages: no I/O, no clock, no threads."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from vehicle_agent.behaviour.authority import Authority, Steering
from vehicle_agent.behaviour.command_desk import CommandDesk
from vehicle_agent.behaviour.energy import EnergyWatch
from vehicle_agent.behaviour.map_exchange import MapExchange, encode_record
from vehicle_agent.behaviour.navigator import Arrived, Navigator, Surroundings
from vehicle_agent.behaviour.plausible import plausible
from vehicle_agent.behaviour.preflight import Checklist, parameters_before_arming, return_altitude
from vehicle_agent.behaviour.return_height import ReturnHeight
from vehicle_agent.behaviour.rhythm import Rhythm
from vehicle_agent.behaviour.standing_orders import StandingOrders
from vehicle_agent.behaviour.status_report import Figures, status_fields
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
    SetSpeed,
    TakeOff,
    VehicleState,
)
from vehicle_agent.wire.keys import TOPIC_BY_NAME
from vehicle_agent.wire.messages import (
    AnyMessage,
    Claim,
    Command,
    CommandResult,
    DeltaRecord,
    Digest,
    MapDelta,
    Orders,
    Outcome,
    Repair,
    Severity,
    Stage,
    Status,
    Verb,
)

RETRY_S = 3.0
TAKE_OFF_ATTEMPTS = 3
LEFT_GROUND_M = 1.0
HEAR_FIRST_S = 10.0
"""A restarted agent adds nothing to its stream before teammates could return what its journal lost of it."""
FLYING = (Stage.WORKING, Stage.HOLDING, Stage.RETURNING)
OWN_MODES = {
    Stage.TAKING_OFF: frozenset({FlightMode.GUIDED}),
    Stage.WORKING: frozenset({FlightMode.GUIDED}),
    Stage.HOLDING: frozenset({FlightMode.GUIDED, FlightMode.HOLD}),
    Stage.RETURNING: frozenset({FlightMode.GUIDED}),
    Stage.LANDING: frozenset({FlightMode.LAND}),
    Stage.YIELDED: frozenset({FlightMode.GUIDED}),
}
"""Flight modes to which an agent's own orders lead; any other is a pilot's or a failsafe's."""


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
        planner = make_planner(
            mission.task.planner,
            plan.grid,
            vehicle.sensor.range_m,
            mission.task.step_m,
            (vehicle.start_enu_m[0], vehicle.start_enu_m[1]),
            rng,
        )
        self._navigator = Navigator(plan, index, planner)
        self._commands = CommandDesk(vehicle.name)
        self._energy = EnergyWatch(mission.stop.battery_reserve)
        self._checklist = Checklist(parameters_before_arming(plan, index))
        self._standing = StandingOrders(plan, index)
        self._errand: Command | None = None
        self._out = Outbox()
        self._now_s = 0.0
        self._state: VehicleState | None = None
        self._next_action_id = 1
        self._status_rhythm = Rhythm(TOPIC_BY_NAME["status"].period_s or 1.0)
        self._map_rhythm = Rhythm(TOPIC_BY_NAME["map"].period_s or 2.0)
        self._digest_rhythm = Rhythm(TOPIC_BY_NAME["digest"].period_s or 5.0)
        self._retry_rhythm = Rhythm(RETRY_S)
        self._authority = Authority()
        self._return_height = ReturnHeight(plan, index)
        self._map_version = 0
        self._began_ms: int | None = None
        self._took_off_at_s: float | None = None
        self._take_offs = 0
        self._left_ground = False
        self._landing_begun = False
        self._handed_back_stage = Stage.WORKING
        self._claimed: Point | None = None
        self._flight_order: Action | None = None
        self._flight_order_refused = False
        self._last_refusal = ""
        self._makes_sense = True
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
        area_cells = self._standing.area_cells
        return float((self.map.observed & area_cells).sum()) / max(1, int(area_cells.sum()))

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
        self._now_s = max(self._now_s, now_s)
        self._take_state(inbox.state)
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
            if self._exchange.own_stream.held:
                self._map_rhythm.wait_until(self._now_s + HEAR_FIRST_S)
        self._state = state or self._state

    def _act(self, state: VehicleState) -> None:
        steers = self._steering(state) is Steering.OWN
        match self.stage:
            case Stage.CONNECTING:
                self._connect(state)
            case Stage.CONFIGURING:
                self._configure(state)
            case Stage.ARMING:
                self._arm(state)
            case Stage.TAKING_OFF:
                self._take_off(state, steers)
            case Stage.WORKING if steers:
                self._work(state)
            case Stage.RETURNING if steers:
                self._return(state)
            case Stage.LANDING:
                self._land(state)
            case _:
                pass
        if self.stage in FLYING:
            self._energy.note(self._now_s, state.battery_fraction)
            self._keep_limits(state)
            if steers:
                self._repeat_refused()

    def _connect(self, state: VehicleState) -> None:
        if state.rival_controller:
            own_id = self._plan.controller_system_id(self._index)
            self._refuse(
                f"another program speaks on this vehicle with system id {own_id}: stop it, or its heartbeats hide "
                "this agent's death from the autopilot"
            )
        elif state.armed and state.landed is not Landed.ON_GROUND:
            self._resume_in_the_air(state)
        elif state.home_enu_m is not None or state.ready_to_arm:
            self._enter(Stage.CONFIGURING, "connected", "autopilot found")

    def _resume_in_the_air(self, state: VehicleState) -> None:
        """Carry on where an earlier run of this agent flew; leave the vehicle to whoever steers it by now."""
        if state.home_enu_m is None or state.landed is Landed.UNKNOWN:
            return
        self._took_off_at_s = self._now_s
        if state.mode is FlightMode.GUIDED:
            self._enter(Stage.WORKING, "resumed", "resumed in the air from the journal")
        else:
            self._yield(state)

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
        elif state.armed and state.landed is not Landed.ON_GROUND and state.mode is not FlightMode.GUIDED:
            self._yield(state)
        elif state.home_enu_m is None:
            return
        elif state.armed and state.mode is FlightMode.GUIDED:
            self._take_offs += 1
            self._left_ground = False
            self._enter(Stage.TAKING_OFF, "armed", "armed")
            self._retry_rhythm.at_once()
        elif state.ready_to_arm and self._retry_rhythm.is_due(self._now_s):
            self._order(Arm())

    def _take_off(self, state: VehicleState, steers: bool) -> None:
        if state.home_enu_m is None:
            return
        climbed_m = state.position_enu_m[2] - state.home_enu_m[2]
        self._left_ground |= climbed_m > LEFT_GROUND_M
        if not state.armed:
            self._disarmed_in_take_off()
        elif climbed_m >= 0.95 * self._take_off_height_m:
            self._took_off_at_s = self._now_s
            self._enter(Stage.WORKING, "took-off", f"airborne at {climbed_m:.0f} m above home")
        elif steers and climbed_m < 0.2 * self._take_off_height_m and self._retry_rhythm.is_due(self._now_s):
            self._order(TakeOff(self._take_off_height_m))

    def _disarmed_in_take_off(self) -> None:
        """Try again only what never began: who has stopped the motors twice, or in the air, means it."""
        if self._left_ground:
            self._enter(Stage.DONE, "landed", "disarmed during take-off by its autopilot or a pilot", Severity.WARNING)
        elif self._take_offs >= TAKE_OFF_ATTEMPTS:
            self._refuse(f"disarmed before take-off {self._take_offs} times: find out why, then start this agent anew")
        else:
            self._enter(Stage.ARMING, "disarmed", "disarmed before take-off; arming again", Severity.WARNING)

    @property
    def _take_off_height_m(self) -> float:
        return self._vehicle.min_above_terrain_m * 1.1

    def _work(self, state: VehicleState) -> None:
        reason = self._reason_to_return(state)
        if reason is None and self._errand is not None:
            self._run_errand(state, self._errand)
        elif reason is None:
            target = self._navigator.work(self._around(state))
            if isinstance(target, Finished):
                reason = target.why
            else:
                self._fly(target)
            if self._standing.sector_cells is not None and not self._navigator.has_sector:
                self._standing.drop_sector()
                self._voice.say(Orders, **self._standing.fields())
        if reason is not None:
            self._go_home(state, reason)

    def _run_errand(self, state: VehicleState, errand: Command) -> None:
        """Fly where the operator sent it; then hold there, or go on with the mission."""
        target = self._navigator.go_to(self._around(state), (errand.point_cm[0] / 100, errand.point_cm[1] / 100))
        if not isinstance(target, Arrived):
            self._fly(target)
            return
        self._errand = None
        if errand.verb is Verb.VISIT:
            self._voice.event(Severity.INFO, "arrived", "at the place it was sent to: on with the mission")
            return
        self._authority.expect_change()
        self._navigator.forget("at the place it was sent to")
        self._enter(Stage.HOLDING, "arrived", "at the place it was sent to")
        self._order(Hold())

    def _reason_to_return(self, state: VehicleState) -> str | None:
        stop = self._plan.mission.stop
        known = self.known_fraction
        if known >= stop.observed_fraction and self._errand is None:
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
            self._begin_landing("over home")
            self._land(state)
        else:
            self._fly(self._navigator.go_home(self._around(state), home))

    def _begin_landing(self, why: str) -> None:
        self._landing_begun = False
        self._navigator.forget(why)
        self._enter(Stage.LANDING, "landing", why)
        self._retry_rhythm.at_once()

    def _land(self, state: VehicleState) -> None:
        if not state.armed:
            self._navigator.forget("on the ground, disarmed")
            self._enter(Stage.DONE, "landed", "landed and disarmed")
        elif state.mode is FlightMode.LAND:
            self._landing_begun = True
        elif not self._landing_begun and self._retry_rhythm.is_due(self._now_s):
            self._order(Land())

    def _steering(self, state: VehicleState) -> Steering:
        """Give way to a pilot or a failsafe; take up the work again when the vehicle is handed back."""
        own_modes = OWN_MODES.get(self.stage)
        if own_modes is None or (self.stage is Stage.LANDING and not self._landing_begun):
            return Steering.OWN
        if not state.armed:
            if self.stage in FLYING or self.stage is Stage.YIELDED:
                self._navigator.forget("disarmed")
                self._release_claim()
                self._enter(Stage.DONE, "landed", "landed and disarmed by its autopilot", Severity.NOTICE)
            return Steering.OWN
        steering = self._authority.judge(self._now_s, state.mode, own_modes)
        if self.stage is Stage.YIELDED:
            if steering is Steering.OWN:
                self._take_back(state)
        elif steering is Steering.FOREIGN:
            self._yield(state)
        return steering

    def _yield(self, state: VehicleState) -> None:
        going_home = self.stage in (Stage.RETURNING, Stage.LANDING)
        self._handed_back_stage = Stage.RETURNING if going_home else Stage.WORKING
        self._navigator.forget(f"mode {state.mode.value}, not ordered by this agent")
        self._release_claim()
        self._enter(Stage.YIELDED, "yielded", self._navigator.why, Severity.WARNING)

    def _take_back(self, state: VehicleState) -> None:
        if state.landed is Landed.ON_GROUND:
            self._enter(Stage.ARMING, "handed-back", "guided again, on the ground")
        elif self._handed_back_stage is Stage.RETURNING:
            self._enter(Stage.RETURNING, "handed-back", "guided again: on the way home")
        else:
            self._enter(Stage.WORKING, "handed-back", "guided again: back to work")

    def _hear(self, message: AnyMessage) -> None:
        if message.sender == self.name:  # an echo, or somebody who took this name
            return
        match message:
            case Status():
                if self._team.hear_status(message, self._now_s):
                    self._voice.event(Severity.NOTICE, "teammate-back", f"{message.sender} is heard again")
            case Claim():
                self._team.hear_claim(message)
            case MapDelta():
                self._receive((message.record,))
            case Repair():
                self._receive(message.records, self._now_s)
            case Digest():
                self._repair(message)
            case Command():
                self._obey(message)
            case _:
                pass

    def _receive(self, records: Iterable[DeltaRecord], repaired_at_s: float | None = None) -> None:
        self._map_version += self._exchange.receive(records, repaired_at_s)

    def _repair(self, digest: Digest) -> None:
        heard = self._team.living()
        living = [name for name in self._plan.vehicle_names if name == self.name or name in heard]
        records = self._exchange.repair_for(digest, living, self._now_s)
        if records:
            self._voice.say(Repair, records=records)

    def _obey(self, command: Command) -> None:
        answer = self._commands.judge(command, self.stage, self._began_ms or 0)
        if answer is None:
            return
        outcome, reason = answer
        if outcome is Outcome.ACCEPTED and (trouble := self._trouble(command)):
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
        if outcome is not Outcome.ACCEPTED or self._state is None:
            return
        match command.verb:
            case Verb.NO_FLY | Verb.AREA | Verb.SECTOR | Verb.SPEED:
                self._stand_by(command)
            case Verb.RELEASE:
                self._team.release(command.subject)
                self._voice.event(Severity.WARNING, "teammate-lost", f"{command.subject} is lost, the operator says")
            case Verb.GO_TO | Verb.VISIT:
                self._errand = command
                self._authority.expect_change()
                self._enter(Stage.WORKING, "sent", "sent to a place by the operator")
                self._fly(self._navigator.stay(self._around(self._state), "sent to a place by the operator"))
            case Verb.HOLD:
                self._errand = None
                self._authority.expect_change()
                self._release_claim()
                self._navigator.forget("held by the operator")
                self._enter(Stage.HOLDING, "holding", "held by the operator")
                self._order(Hold())
            case Verb.RESUME:
                self._authority.expect_change()
                self._enter(Stage.WORKING, "resumed", "resumed by the operator")
                self._fly(self._navigator.stay(self._around(self._state), "resumed"))
            case Verb.RETURN:
                self._errand = None
                self._authority.expect_change()
                self._go_home(self._state, "called home by the operator")
            case Verb.LAND:
                self._errand = None
                self._release_claim()
                self._begin_landing("landing here, ordered by the operator")
                self._land(self._state)

    def _trouble(self, command: Command) -> str:
        if command.verb is Verb.RELEASE:
            return "" if command.subject in self._team.living() else "not a teammate that counts as living"
        home = self._state.home_enu_m if self._state else None
        return self._standing.trouble(command, home[:2] if home else self._start_enu_m()[:2])

    def _stand_by(self, command: Command) -> None:
        """Follow an order that stays: zone, area, sector or speed."""
        standing = self._standing
        standing.take(command)
        self._navigator.limit(standing.allowed, standing.area_cells, standing.sector_cells)
        if command.verb is Verb.SPEED:
            self._order(SetSpeed(standing.speed_limit_cm_s / 100 or self._vehicle.speed_m_s))
        self._voice.say(Orders, **standing.fields())

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

    def _keep_limits(self, state: VehicleState) -> None:
        """Keep the failsafe's way home above all known ground; in a resumed flight, set what was to be set before."""
        if (order := self._checklist.next_order()) is not None:
            self._checklist.submitted(self._order(order))
        if state.home_enu_m is not None:
            height_m = self._return_height.due_m(self._now_s, self.map, state.home_enu_m[2])
            if height_m is not None:
                self._return_height.asked(self._order(return_altitude(height_m)), height_m)

    def _repeat_refused(self) -> None:
        """Give the last flight order again when the autopilot did not take it: else it would be waited for in vain."""
        if self._flight_order_refused and self._flight_order and self._retry_rhythm.is_due(self._now_s):
            self._order(self._flight_order.order)

    def _report(self) -> None:
        if self._map_rhythm.is_due(self._now_s) and (record := self._exchange.next_record()) is not None:
            self._out.journal.append(encode_record(record))
            self._voice.say(MapDelta, record=record)
        if self._digest_rhythm.is_due(self._now_s):
            self._voice.say(Digest, streams=self._exchange.digest())
        if self._state is not None and self._status_rhythm.is_due(self._now_s):
            self._say_status(self._state)

    def _say_status(self, state: VehicleState) -> None:
        figures = Figures(
            self.known_fraction,
            self.first_seen_cells,
            self.bytes_sent,
            self.messages_dropped + self._exchange.refused,
        )
        home = state.home_enu_m or self._start_enu_m()
        fields = status_fields(
            self.stage, state, self._navigator, home, self._take_off_height_m, self._return_height.height_m, figures
        )
        self._voice.say(Status, **fields)

    def _hear_result(self, result: ActionResult) -> None:
        self._checklist.hear(result)
        self._return_height.hear(result)
        is_flight_order = self._flight_order is not None and result.action_id == self._flight_order.action_id
        if is_flight_order:
            self._flight_order_refused = not result.accepted
        if result.accepted or result.text == self._last_refusal:
            return
        if self.stage is Stage.ARMING:
            self._last_refusal = result.text
            self._voice.event(Severity.NOTICE, "arming-refused", result.text)
        elif is_flight_order or self.stage is Stage.TAKING_OFF:
            self._last_refusal = result.text
            self._voice.event(Severity.WARNING, "order-refused", result.text or "the autopilot did not take an order")

    def _order(self, order: Order) -> int:
        action = Action(self._next_action_id, order)
        self._next_action_id += 1
        self._out.actions.append(action)
        if isinstance(order, GoTo | Hold):
            self._flight_order, self._flight_order_refused = action, False
        return action.action_id

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
