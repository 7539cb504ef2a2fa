"""One vehicle's flight, stage by stage: what it does once it has set out, and how it comes back to the ground.

It orders and says; who steers is judged before anything is ordered, so that a pilot or a failsafe is never fought.
"""

from __future__ import annotations

from vehicle_agent.behaviour.authority import Authority, Steering
from vehicle_agent.behaviour.body import body_of
from vehicle_agent.behaviour.energy import EnergyWatch, Headway
from vehicle_agent.behaviour.goal_claim import GoalClaim
from vehicle_agent.behaviour.guide import Arrived, Guide, Surroundings
from vehicle_agent.behaviour.home_column import HomeColumn
from vehicle_agent.behaviour.intent import Intent
from vehicle_agent.behaviour.knowledge import Knowledge
from vehicle_agent.behaviour.order_book import OrderBook
from vehicle_agent.behaviour.preflight import Checklist, return_altitude
from vehicle_agent.behaviour.return_height import ReturnHeight
from vehicle_agent.behaviour.rhythm import Rhythm
from vehicle_agent.behaviour.setting_out import SETTING_OUT, Change, SettingOut, yielding
from vehicle_agent.behaviour.standing_orders import StandingOrders
from vehicle_agent.behaviour.voice import Voice
from vehicle_agent.domain.frames import Point
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.tasks import CoverTask
from vehicle_agent.planning.interface import Finished
from vehicle_agent.planning.travel import way_length_m
from vehicle_agent.ports import (
    ActionResult,
    FlightMode,
    GoTo,
    Hold,
    SetSpeed,
    VehicleState,
)
from vehicle_agent.wire.messages import Command, Orders, Severity, Stage, Verb

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


class Flight:
    """The stages of one vehicle.

    Attributes
    ----------
    stage
        Where it stands.
    navigator
        Where it flies, and why.
    standing
        What operators have ordered for good.
    return_height
        Of its autopilot's own return.
    """

    def __init__(
        self,
        plan: MissionPlan,
        index: int,
        navigator: Guide,
        knowledge: Knowledge,
        voice: Voice,
        orders: OrderBook,
        status_rhythm: Rhythm,
    ) -> None:
        self._plan, self._index, self._vehicle = plan, index, plan.mission.vehicles[index]
        self._body = body_of(plan, index)
        self._knowledge, self._voice, self._orders, self._status_rhythm = knowledge, voice, orders, status_rhythm
        self._claim = GoalClaim(voice)
        self._column = HomeColumn(plan, index)
        self._energy, self._headway = EnergyWatch(plan.mission.stop.battery_reserve), Headway()
        self._checklist = Checklist(self._body.parameters())
        self._setting_out = SettingOut(plan, index, self._body, self._checklist, self._column, knowledge, voice, orders)
        self._authority = Authority()
        self._errand: Command | None = None
        self._now_s = 0.0
        self._took_off_at_s: float | None = None
        self._landing_begun = False
        self._waits_told = False
        self._handed_back_stage = Stage.WORKING
        self._told_intent: Intent | None = None
        self.navigator = navigator
        self.standing = StandingOrders(plan, index)
        self.return_height = ReturnHeight(plan, index)
        self.stage = Stage.CONNECTING

    def step(self, now_s: float, state: VehicleState) -> None:
        """Act on the autopilot's newest state."""
        self._now_s = now_s
        steers = self._steering(state) is Steering.OWN
        match self.stage:
            case stage if stage in SETTING_OUT:
                self._set_out(self._setting_out.step(now_s, stage, state, steers))
            case Stage.WORKING if steers:
                self._work(state)
            case Stage.HOLDING if steers:
                self._hold(state)
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
                self._orders.repeat_refused(self._now_s)
        self._tell_intent()

    @property
    def intent(self) -> Intent | None:
        """The leg that it means to fly next and waits with for teammates' words."""
        return self._setting_out.intent if self.stage is Stage.ARMING else self.navigator.intent

    def _tell_intent(self) -> None:
        """Say at once what it means to fly, or that it no longer does."""
        if (intent := self.intent) is self._told_intent:
            return
        self._told_intent = intent
        self._status_rhythm.at_once()
        if intent is not None and intent.waypoint is not None:
            self._claim.follow(intent.waypoint)

    def _set_out(self, change: Change | None) -> None:
        """Enter the next stage before the work, or the first one of it."""
        if change is None:
            return
        if change.stage in (Stage.WORKING, Stage.YIELDED):
            self._took_off_at_s = self._now_s
            self._handed_back_stage = Stage.WORKING
        if change.stage in (Stage.REFUSED, Stage.YIELDED):
            self.navigator.forget(change.text)
        self._enter(change)

    @property
    def take_off_height_m(self) -> float:
        return self._body.set_out_height_m()

    def _work(self, state: VehicleState) -> None:
        reason = self._reason_to_return(state)
        if reason is None and self._errand is not None:
            self._run_errand(state, self._errand)
        elif reason is None:
            target = self.navigator.work(self._around(state))
            if isinstance(target, Finished):
                reason = target.why
            else:
                self._fly(target)
                if self.navigator.is_idle:
                    self._claim.release()
            if self.standing.sector_cells is not None and not self.navigator.has_sector:
                self.standing.drop_sector()
                self._voice.say(Orders, **self.standing.fields())
        if reason is not None:
            self._go_home(state, reason)

    def _run_errand(self, state: VehicleState, errand: Command) -> None:
        """Fly where the operator sent it; then hold there, or go on with the mission."""
        target = self.navigator.go_to(self._around(state), (errand.point_cm[0] / 100, errand.point_cm[1] / 100))
        if not isinstance(target, Arrived):
            self._fly(target)
            return
        self._errand = None
        if errand.verb is Verb.VISIT:
            self._voice.event(Severity.INFO, "arrived", "at the place it was sent to: on with the mission")
            return
        self._authority.expect_change()
        self.navigator.forget("at the place it was sent to")
        self._enter(Change(Stage.HOLDING, "arrived", "at the place it was sent to"))
        self._orders.give(Hold())

    def _reason_to_return(self, state: VehicleState) -> str | None:
        stop = self._plan.mission.stop
        known = self._knowledge.known_fraction(self.standing.area_cells)
        covers = isinstance(self._plan.mission.task, CoverTask)
        if known >= stop.observed_fraction and self._errand is None and not covers:
            return f"{100 * known:.1f} % of the area is known"
        if self._took_off_at_s is not None and self._now_s - self._took_off_at_s > stop.time_limit_s:
            return f"time limit of {stop.time_limit_s:.0f} s reached"
        return self._low_battery(state)

    def _low_battery(self, state: VehicleState) -> str | None:
        """Why the charge calls home, one phrase; None while it does not."""
        if state.home_enu_m is not None:
            way_s = way_length_m(state.position_enu_m, state.home_enu_m[:2]) / self._vehicle.speed_m_s
            if self._energy.must_return(state.battery_fraction, way_s):
                return f"battery at {100 * (state.battery_fraction or 0.0):.0f} %, home is {way_s:.0f} s away"
        return None

    def _hold(self, state: VehicleState) -> None:
        """Stay, but for making way; only a charge that just about reaches home ends it."""
        if (reason := self._low_battery(state)) is not None:
            self._authority.expect_change()
            self._go_home(state, f"held no longer: {reason}")
        elif not self._body.rests(state) and (aside := self.navigator.make_way(self._around(state))) is not None:
            self._authority.expect_change()
            self._fly(aside)

    def _go_home(self, state: VehicleState, reason: str) -> None:
        self._enter(Change(Stage.RETURNING, "returning", reason))
        self._waits_told = False
        self._headway.begin(self._now_s)
        self._claim.release()
        self._fly(self.navigator.stay(self._around(state), reason))

    def _return(self, state: VehicleState) -> None:
        home = self.home_enu_m(state)
        if not self.navigator.is_over_home(state, home):
            self._fly(self.navigator.go_home(self._around(state), home))
            self._come_down_held_up(state, home)
            return
        east_m, north_m, _ = state.position_enu_m
        rival = self._column.rival(self._around(state), (east_m, north_m, home[2]))
        if not rival or self._energy.must_land(state.battery_fraction):
            self._begin_landing(f"at home, and can wait no longer for {rival} to make way" if rival else "over home")
            self._land(state)
        else:
            self._wait_at_home(state, f"waits at home: {rival} is in the way")

    def _come_down_held_up(self, state: VehicleState, home: Point) -> None:
        """Go down short of home when the way there stays taken until the charge is nearly gone."""
        stuck = self._headway.is_stuck(self._now_s, way_length_m(state.position_enu_m, home[:2]))
        if not (stuck and self._energy.must_land(state.battery_fraction)):
            return
        east_m, north_m, _ = state.position_enu_m
        rival = self._column.rival(self._around(state), (east_m, north_m, home[2]))
        if not rival or self._energy.is_nearly_gone(state.battery_fraction):
            self._begin_landing("the way home stays taken and the charge is nearly gone: down here")
            self._land(state)

    def _wait_at_home(self, state: VehicleState, why: str) -> None:
        """Stay where teammates see that it wants to go on to its home, and make way."""
        if self.navigator.why != why:
            self._fly(self.navigator.stay(self._around(state), why))
        if not self._waits_told:
            self._waits_told = True
            self._voice.event(Severity.NOTICE, "waiting", why)

    def _begin_landing(self, why: str) -> None:
        self._landing_begun = False
        self.navigator.forget(why)
        self._enter(Change(Stage.LANDING, "landing", why))
        self._orders.try_at_once()

    def _land(self, state: VehicleState) -> None:
        if not state.armed:
            self.navigator.forget("on the ground, disarmed")
            self._enter(Change(Stage.DONE, "landed", "landed and disarmed"))
            return
        self._landing_begun |= state.mode is FlightMode.LAND
        if (order := self._body.end_order(state, self._landing_begun)) is not None:
            self._orders.retry(order, self._now_s)

    def _steering(self, state: VehicleState) -> Steering:
        """Give way to a pilot or a failsafe; take up the work again when the vehicle is handed back."""
        own_modes = OWN_MODES.get(self.stage)
        if own_modes is None or (self.stage is Stage.LANDING and not self._landing_begun):
            return Steering.OWN
        if not state.armed:
            if self.stage in FLYING or self.stage is Stage.YIELDED:
                self.navigator.forget("disarmed")
                self._claim.release()
                self._enter(Change(Stage.DONE, "landed", "landed and disarmed by its autopilot", Severity.NOTICE))
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
        change = yielding(state)
        self.navigator.forget(change.text)
        self._claim.release()
        self._enter(change)

    def _take_back(self, state: VehicleState) -> None:
        if self._body.rests(state):
            self._enter(Change(Stage.ARMING, "handed-back", "guided again, on the ground"))
        elif self._handed_back_stage is Stage.RETURNING:
            self._headway.begin(self._now_s)
            self._enter(Change(Stage.RETURNING, "handed-back", "guided again: on the way home"))
        else:
            self._enter(Change(Stage.WORKING, "handed-back", "guided again: back to work"))

    def obey(self, command: Command, now_s: float, state: VehicleState) -> None:
        """Do what an operator's command asks for; the caller has judged and answered it."""
        self._now_s = now_s
        match command.verb:
            case Verb.NO_FLY | Verb.AREA | Verb.SECTOR | Verb.SPEED:
                self._stand_by(command)
            case Verb.RELEASE if command.subject not in self._knowledge.team.living():
                pass  # its silence has been noticed here already
            case Verb.RELEASE:
                self._knowledge.team.release(command.subject)
                self._voice.event(Severity.WARNING, "teammate-lost", f"{command.subject} is lost, the operator says")
            case Verb.GO_TO | Verb.VISIT:
                self._errand = command
                self._authority.expect_change()
                self._enter(Change(Stage.WORKING, "sent", "sent to a place by the operator"))
                self._fly(self.navigator.stay(self._around(state), "sent to a place by the operator"))
            case Verb.HOLD:
                self._errand = None
                self._authority.expect_change()
                self._claim.release()
                self.navigator.forget("held by the operator")
                self._enter(Change(Stage.HOLDING, "holding", "held by the operator"))
                self._orders.give(Hold())
            case Verb.RESUME:
                self._authority.expect_change()
                self._enter(Change(Stage.WORKING, "resumed", "resumed by the operator"))
                self._fly(self.navigator.stay(self._around(state), "resumed"))
            case Verb.RETURN:
                self._errand = None
                self._authority.expect_change()
                self._go_home(state, "called home by the operator")
            case Verb.LAND:
                self._errand = None
                self._claim.release()
                self._begin_landing("landing here, ordered by the operator")
                self._land(state)

    def trouble(self, command: Command, state: VehicleState | None) -> str:
        """Why a command cannot be obeyed here, one sentence; empty when it can."""
        if command.verb is Verb.RELEASE:
            return "" if self._knowledge.team.knows(command.subject) else "not a teammate that was ever heard"
        return self.standing.trouble(command, self.home_enu_m(state)[:2])

    def _stand_by(self, command: Command) -> None:
        """Follow an order that stays: zone, area, sector or speed."""
        standing = self.standing
        standing.take(command)
        self.navigator.limit(standing.allowed, standing.area_cells, standing.sector_cells)
        if command.verb is Verb.SPEED:
            self._orders.give(SetSpeed(standing.speed_limit_cm_s / 100 or self._vehicle.speed_m_s))
        self._voice.say(Orders, **standing.fields())

    def hear(self, result: ActionResult) -> None:
        """Take an order's result; a refusal is told once."""
        self._checklist.hear(result)
        self.return_height.hear(result)
        is_flight_order = self._orders.hear(result)
        arming = self.stage is Stage.ARMING
        if (arming or is_flight_order or self.stage is Stage.TAKING_OFF) and self._orders.is_news(result):
            severity, code = (Severity.NOTICE, "arming-refused") if arming else (Severity.WARNING, "order-refused")
            self._voice.event(severity, code, result.text or "the autopilot did not take an order")

    def _around(self, state: VehicleState) -> Surroundings:
        return self._knowledge.around(self._now_s, state, at_work=self.stage in (Stage.WORKING, Stage.HOLDING))

    def _fly(self, target: Point | None) -> None:
        if target is None:
            return
        self._orders.give(GoTo(target))
        self._claim.follow(self.navigator.waypoint)
        self._status_rhythm.at_once()

    def _keep_limits(self, state: VehicleState) -> None:
        """Keep the failsafe's way home above all known ground; in a resumed flight, set what was to be set before."""
        if (order := self._checklist.next_order()) is not None:
            self._checklist.submitted(self._orders.give(order))
        if state.home_enu_m is not None and self._body.keeps_return_height:
            height_m = self.return_height.due_m(self._now_s, self._knowledge.shared, state.home_enu_m[2])
            if height_m is not None:
                self.return_height.asked(self._orders.give(return_altitude(height_m)), height_m)

    def _enter(self, change: Change) -> None:
        self.stage = change.stage
        self._voice.event(change.severity, change.code, change.text)
        self._status_rhythm.at_once()

    def home_enu_m(self, state: VehicleState | None) -> Point:
        """Where its autopilot returns to; before that is known, where the mission lets it start."""
        if state is not None and state.home_enu_m is not None:
            return state.home_enu_m
        start = self._vehicle.start_enu_m
        up_m = start[2] if len(start) == 3 else state.position_enu_m[2] if state is not None else 0.0
        return (start[0], start[1], up_m)
