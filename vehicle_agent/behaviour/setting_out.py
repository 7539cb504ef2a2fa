"""From the first word of a vehicle's autopilot to where its work begins."""

from __future__ import annotations

from dataclasses import dataclass

from vehicle_agent.behaviour.body import Body
from vehicle_agent.behaviour.home_column import HomeColumn
from vehicle_agent.behaviour.intent import Intent, awaited, within_reach_m
from vehicle_agent.behaviour.knowledge import Knowledge
from vehicle_agent.behaviour.leg import Leg
from vehicle_agent.behaviour.order_book import OrderBook
from vehicle_agent.behaviour.preflight import Checklist
from vehicle_agent.behaviour.voice import Voice
from vehicle_agent.domain.frames import Point
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.ports import Arm, FlightMode, VehicleState
from vehicle_agent.wire.messages import Severity, Stage

TAKE_OFF_ATTEMPTS = 3
SETTING_OUT = (Stage.CONNECTING, Stage.CONFIGURING, Stage.ARMING, Stage.TAKING_OFF)


@dataclass(frozen=True, slots=True)
class Change:
    """Which stage comes next, with the code and the words of the event that tells it."""

    stage: Stage
    code: str
    text: str
    severity: Severity = Severity.INFO


class SettingOut:
    """One vehicle's stages before its work.

    Parameters
    ----------
    plan, index
        The mission, and which of its vehicles this is.

    Attributes
    ----------
    intent
        The way up that it has told of and waits with for teammates' words, until it sets out.
    """

    def __init__(
        self,
        plan: MissionPlan,
        index: int,
        body: Body,
        checklist: Checklist,
        column: HomeColumn,
        knowledge: Knowledge,
        voice: Voice,
        orders: OrderBook,
    ) -> None:
        self._controller_id = plan.controller_system_id(index)
        self._within_m, self._patience_s = within_reach_m(plan), plan.mission.safety.teammate_silence_s
        self._body, self._checklist, self._column = body, checklist, column
        self._knowledge, self._voice, self._orders = knowledge, voice, orders
        self._take_offs = 0
        self._left_ground = False
        self._waits = False
        self.intent: Intent | None = None

    def step(self, now_s: float, stage: Stage, state: VehicleState, steers: bool) -> Change | None:
        """Order what the stage needs; the next stage, or None while this one lasts."""
        if stage is not Stage.ARMING:
            self.intent = None
        match stage:
            case Stage.CONNECTING:
                return self._connect(state)
            case Stage.CONFIGURING:
                return self._configure()
            case Stage.ARMING:
                return self._arm(now_s, state)
            case _:
                return self._take_off(now_s, state, steers)

    def _connect(self, state: VehicleState) -> Change | None:
        if state.rival_controller:
            return _refusal(
                f"another program speaks on this vehicle with system id {self._controller_id}: stop it, or its "
                "heartbeats hide this agent's death from the autopilot"
            )
        if state.armed and not self._body.rests(state):
            return self._resume_in_the_air(state)
        if state.home_enu_m is not None or state.ready_to_arm:
            return Change(Stage.CONFIGURING, "connected", "autopilot found")
        return None

    def _resume_in_the_air(self, state: VehicleState) -> Change | None:
        """Carry on where an earlier run of this agent flew; leave the vehicle to whoever steers it by now."""
        if state.home_enu_m is None or self._body.is_unsure(state):
            return None
        if state.mode is FlightMode.GUIDED:
            return Change(Stage.WORKING, "resumed", "resumed in the air from the journal")
        return yielding(state)

    def _configure(self) -> Change | None:
        if self._checklist.failed:
            return _refusal(self._checklist.failed)
        if self._checklist.done:
            return Change(Stage.ARMING, "configured", "the autopilot now watches this agent")
        if (order := self._checklist.next_order()) is not None:
            self._checklist.submitted(self._orders.give(order))
        return None

    def _arm(self, now_s: float, state: VehicleState) -> Change | None:
        if state.rival_controller:
            return self._connect(state)
        if state.armed and not self._body.rests(state) and state.mode is not FlightMode.GUIDED:
            return yielding(state)
        if state.home_enu_m is None or not self._is_free(now_s, state, state.home_enu_m):
            return None
        if state.armed and state.mode is FlightMode.GUIDED:
            self._take_offs += 1
            self._left_ground = False
            self._orders.try_at_once()
            return Change(Stage.TAKING_OFF, "armed", "armed")
        if state.ready_to_arm:
            self._orders.retry(Arm(), now_s)
        return None

    def _is_free(self, now_s: float, state: VehicleState, home: Point) -> bool:
        """Whether nobody is over home nor on the way there; who works there hears of it, and makes way."""
        east_m, north_m, _ = state.position_enu_m
        around = self._knowledge.around(now_s, state, at_work=False)
        top: Point = (east_m, north_m, home[2] + self._body.set_out_height_m())
        rival = self._column.rival(around, top, state.stamp_ms if self.intent is None else self.intent.since_ms)
        if rival and not self._waits:
            self._voice.event(Severity.NOTICE, "waiting", f"waits to set out: {rival} is in the way")
        self._waits = bool(rival)
        if rival:
            self.intent = None
            return False
        if self.intent is None:
            self.intent = Intent(Leg(top, "sets out"), None, state.stamp_ms, now_s)
        lines = ((state.position_enu_m, top),)
        since_ms, since_s = self.intent.since_ms, self.intent.since_s
        return not awaited(lines, since_ms, since_s, around.whereabouts, self._within_m, self._patience_s)

    def _take_off(self, now_s: float, state: VehicleState, steers: bool) -> Change | None:
        if state.home_enu_m is None:
            return None
        self._left_ground |= self._body.has_set_out(state, state.home_enu_m)
        if not state.armed:
            return self._disarmed()
        if self._body.is_under_way(state, state.home_enu_m):
            return Change(Stage.WORKING, *self._body.word(state.position_enu_m[2] - state.home_enu_m[2]))
        if steers and not self._left_ground:
            self._orders.retry(self._body.set_out(state.home_enu_m), now_s)
        return None

    def _disarmed(self) -> Change:
        """Try again only what never began: who has stopped the motors twice, or in the air, means it."""
        if self._left_ground:
            text = "disarmed during take-off by its autopilot or a pilot"
            return Change(Stage.DONE, "landed", text, Severity.WARNING)
        if self._take_offs >= TAKE_OFF_ATTEMPTS:
            return _refusal(
                f"disarmed before take-off {self._take_offs} times: find out why, then start this agent anew"
            )
        return Change(Stage.ARMING, "disarmed", "disarmed before take-off; arming again", Severity.WARNING)


def _refusal(why: str) -> Change:
    return Change(Stage.REFUSED, "refused", why, Severity.ERROR)


def yielding(state: VehicleState) -> Change:
    """Give way to whoever has changed the flight mode."""
    text = f"mode {state.mode.value}, not ordered by this agent"
    return Change(Stage.YIELDED, "yielded", text, Severity.WARNING)
