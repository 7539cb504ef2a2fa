"""One agent on a bench: a toy autopilot that obeys at once, and everything that the agent says and orders."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from tests.fakes.sim_missions import GROUND_M, sim_plan
from vehicle_agent.agent import VehicleAgent
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.sensing import visible_surface
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.ports import (
    Action,
    ActionResult,
    Arm,
    Disarm,
    FlightMode,
    GoTo,
    Hold,
    Inbox,
    Land,
    Landed,
    Order,
    Outbox,
    ReturnHome,
    SensorScan,
    SetParameter,
    SetSpeed,
    TakeOff,
    VehicleState,
)
from vehicle_agent.wire.codec import Codec
from vehicle_agent.wire.messages import AnyMessage, Command, Event, Stage, Status, Verb

EPOCH_S = 1_767_225_600.0
CLIMB_M_S = 5.0
M = TypeVar("M", bound=AnyMessage)
O = TypeVar("O", bound=Order)  # noqa: E741


class AgentBench:
    """Steps one agent of a level mission against a vehicle without inertia.

    Attributes
    ----------
    state
        What the autopilot tells next; tests change it with `set`.
    refuse
        Tells for an order why it is refused; empty accepts.
    deaf
        The autopilot drops every order without an answer.
    nonsense
        Fields of the state that the autopilot tells wrongly.
    actions, messages, journal
        Everything since the start, in order.
    """

    def __init__(
        self,
        plan: MissionPlan | None = None,
        index: int = 0,
        boot_id: int = 5,
        journal: Iterable[bytes] = (),
        start: Point | None = None,
        time_s: float = 0.0,
    ) -> None:
        self.plan = plan or sim_plan(vehicles=2)
        vehicle = self.plan.mission.vehicles[index]
        self.agent = VehicleAgent(self.plan, index, boot_id, np.random.default_rng(0), journal)
        home = (vehicle.start_enu_m[0], vehicle.start_enu_m[1], GROUND_M)
        self.time_s = time_s
        self.state = VehicleState(
            stamp_ms=0,
            position_enu_m=start or home,
            landed=Landed.ON_GROUND,
            mode=FlightMode.MANUAL,
            battery_fraction=1.0,
            ready_to_arm=True,
            home_enu_m=home,
        )
        self.refuse: Callable[[Order], str] = lambda order: ""
        self.deaf = False
        self.nonsense: dict[str, object] = {}
        self.sees = True
        self.journal: list[bytes] = []
        self.actions: list[Action] = []
        self.messages: list[AnyMessage] = []
        self._speed_m_s = vehicle.speed_m_s
        self._range_m = vehicle.sensor.range_m
        self._level = np.full(self.plan.grid.shape, GROUND_M)
        self._target: Point | None = None
        self._results: list[ActionResult] = []
        self._heard: list[AnyMessage] = []
        self._codec = Codec()

    def set(self, **changes: object) -> None:
        self.state = replace(self.state, **changes)  # type: ignore[arg-type]

    def hear(self, *messages: AnyMessage) -> None:
        self._heard += messages

    def tick(self, dt_s: float = 0.5, tell_state: bool = True, scans: list[SensorScan] | None = None) -> Outbox:
        """Let time pass, the vehicle move and the agent decide."""
        self.time_s += dt_s
        self._move(dt_s)
        self.set(stamp_ms=round((EPOCH_S + self.time_s) * 1000))
        told = replace(self.state, **self.nonsense)  # type: ignore[arg-type]
        inbox = Inbox(state=told if tell_state else None, scans=scans or self._scans())
        inbox.results, self._results = self._results, []
        inbox.messages, self._heard = self._heard, []
        outbox = self.agent.step(EPOCH_S + self.time_s, inbox)
        self.actions += outbox.actions
        self.journal += outbox.journal
        for message in outbox.messages:
            assert self._codec.decode(self._codec.encode(message)) == message  # teammates can read it
        self.messages += outbox.messages
        for action in outbox.actions:
            self._obey(action)
        return outbox

    def run(self, seconds: float, dt_s: float = 0.5) -> None:
        for _ in range(round(seconds / dt_s)):
            self.tick(dt_s)

    def run_until(self, *stages: Stage, limit_s: float = 3_000.0) -> None:
        """Run until the agent is in one of the stages; fails after so much simulated time."""
        end_s = self.time_s + limit_s
        while self.agent.stage not in stages:
            assert self.time_s < end_s, f"still {self.agent.stage.name} after {limit_s} s"
            self.tick()

    def orders(self, kind: type[O], since: int = 0) -> list[O]:
        return [action.order for action in self.actions[since:] if isinstance(action.order, kind)]

    def said(self, kind: type[M], since: int = 0) -> list[M]:
        return [message for message in self.messages[since:] if isinstance(message, kind)]

    def codes(self) -> list[str]:
        return [event.code for event in self.said(Event)]

    def stages_told(self) -> list[Stage]:
        """Stages as statuses told them, each change once."""
        told: list[Stage] = []
        for status in self.said(Status):
            if not told or told[-1] is not status.stage:
                told.append(status.stage)
        return told

    def _scans(self) -> list[SensorScan]:
        if not self.sees or not self.state.armed or not all(map(math.isfinite, self.state.position_enu_m)):
            return []
        cells = visible_surface(self.plan.grid, self._level, self.state.position_enu_m, self._range_m)
        stamp_ms = round((EPOCH_S + self.time_s) * 1000)
        elevations = np.full(len(cells), round(GROUND_M * 10), dtype=np.int32)
        return [SensorScan(CellObservations(cells, elevations, np.full(len(cells), stamp_ms, dtype=np.int64)))]

    def _obey(self, action: Action) -> None:
        if self.deaf:
            return
        trouble = self.refuse(action.order)
        self._results.append(ActionResult(action.action_id, not trouble, trouble))
        if trouble:
            return
        match action.order:
            case Arm():
                self.set(armed=True, mode=FlightMode.GUIDED)
            case Disarm():
                self.set(armed=False)
            case TakeOff(height_m):
                assert self.state.home_enu_m is not None
                east_m, north_m, _ = self.state.position_enu_m
                self._target = (east_m, north_m, self.state.home_enu_m[2] + height_m)
                self.set(landed=Landed.TAKING_OFF)
            case GoTo(target):
                self._target = target
                self.set(mode=FlightMode.GUIDED)
            case Hold():
                self._target = None
                self.set(mode=FlightMode.HOLD)
            case Land():
                self._target = (*self.state.position_enu_m[:2], GROUND_M)
                self.set(mode=FlightMode.LAND, landed=Landed.LANDING)
            case ReturnHome() | SetParameter() | SetSpeed():
                pass

    def _move(self, dt_s: float) -> None:
        if self._target is None or not self.state.armed:
            self.set(velocity_enu_m_s=(0.0, 0.0, 0.0))
            return
        here = self.state.position_enu_m
        away_m = math.dist(here, self._target)
        pace_m_s = self._speed_m_s if math.dist(here[:2], self._target[:2]) > 1.0 else CLIMB_M_S
        part = min(1.0, pace_m_s * dt_s / away_m) if away_m > 0.0 else 1.0
        east, north, up = (h + part * (t - h) for h, t in zip(here, self._target, strict=True))
        pace = (0.0, 0.0, 0.0) if part >= 1.0 else (east - here[0], north - here[1], up - here[2])
        self.set(position_enu_m=(east, north, up), velocity_enu_m_s=tuple(v / dt_s for v in pace))
        if up > GROUND_M + 1.0 and self.state.landed in (Landed.ON_GROUND, Landed.TAKING_OFF):
            self.set(landed=Landed.IN_AIR)
        if self.state.mode is FlightMode.LAND and part >= 1.0:
            self.set(landed=Landed.ON_GROUND, armed=False)


def command(
    verb: Verb, number: int = 1, target: str = "copter-0", stamp_ms: int | None = None, **payload: Any
) -> Command:
    """A station's order; no bench has run long enough to find it old."""
    return Command(
        sender="station-1",
        boot_id=3,
        sequence=number,
        stamp_ms=round((EPOCH_S + 1e4) * 1000) if stamp_ms is None else stamp_ms,
        command_id=number,
        verb=verb,
        targets=(target,),
        **payload,
    )


def working(bench: AgentBench | None = None) -> AgentBench:
    """A bench whose vehicle has been at work for a moment: it has thought of its first leg, and flies it."""
    bench = bench or AgentBench()
    bench.run_until(Stage.WORKING)
    bench.run(6.0)
    return bench


def flight_orders(bench: AgentBench, since: int) -> list[object]:
    """Everything ordered since then but parameters."""
    return [a.order for a in bench.actions[since:] if not isinstance(a.order, SetParameter)]
