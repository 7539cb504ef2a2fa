"""An agent that decides nothing: it does what a script says and remembers what it was told."""

from __future__ import annotations

from collections.abc import Callable

from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.grid import Grid
from vehicle_agent.link.counters import LinkCounters
from vehicle_agent.ports import Action, ActionResult, AutopilotText, Inbox, Outbox, SensorScan, VehicleState
from vehicle_agent.wire.messages import AnyMessage, Stage


class ScriptedAgent:
    """Answers each step with what `script` makes of it.

    Attributes
    ----------
    steps
        (now_s, inbox) of every step.
    """

    def __init__(self, script: Callable[[float, Inbox], Outbox] = lambda _now_s, _inbox: Outbox()) -> None:
        self.stage = Stage.CONNECTING
        self.bytes_sent = 0
        self.messages_dropped = 0
        self.steps: list[tuple[float, Inbox]] = []
        self._script = script
        self.map = ElevationMap(Grid(0.0, 0.0, 10.0, 4, 3))

    @property
    def finished(self) -> bool:
        return self.stage is Stage.DONE

    @property
    def first_seen_cells(self) -> float:
        return 1.5

    def step(self, now_s: float, inbox: Inbox) -> Outbox:
        self.steps.append((now_s, inbox))
        return self._script(now_s, inbox)


class PlayedPorts:
    """All four ports in one: gives out what a test put in, and writes down in `log` what it was asked, in order."""

    def __init__(self) -> None:
        self.log: list[tuple[str, object]] = []
        self.states: list[VehicleState] = []
        self.results: list[ActionResult] = []
        self.texts: list[AutopilotText] = []
        self.messages: list[AnyMessage] = []
        self.scans: list[SensorScan] = []
        self.counters = LinkCounters()

    class _Autopilot:
        def __init__(self, ports: PlayedPorts) -> None:
            self._ports = ports

        def poll(self) -> tuple[VehicleState | None, list[ActionResult], list[AutopilotText]]:
            ports = self._ports
            state = ports.states.pop(0) if ports.states else None
            results, ports.results = ports.results, []
            texts, ports.texts = ports.texts, []
            return state, results, texts

        def submit(self, action: Action) -> None:
            self._ports.log.append(("submit", action))

    class _Team:
        def __init__(self, ports: PlayedPorts) -> None:
            self._ports = ports

        def poll(self) -> list[AnyMessage]:
            messages, self._ports.messages = self._ports.messages, []
            return messages

        def publish(self, message: AnyMessage) -> None:
            self._ports.log.append(("publish", message))

    class _Payload:
        def __init__(self, ports: PlayedPorts) -> None:
            self._ports = ports

        def poll(self) -> list[SensorScan]:
            scans, self._ports.scans = self._ports.scans, []
            return scans

    @property
    def autopilot(self) -> _Autopilot:
        return self._Autopilot(self)

    @property
    def team(self) -> _Team:
        return self._Team(self)

    @property
    def payload(self) -> _Payload:
        return self._Payload(self)

    def records(self) -> list[bytes]:
        return []

    def append(self, records: list[bytes]) -> None:
        self.log += [("journal", record) for record in records]
