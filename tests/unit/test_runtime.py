"""The agent's event loop: when it steps, in what order it acts, which time it tells, what it leaves behind."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path

import numpy as np
import pytest

from tests.fakes.scripted_agent import PlayedPorts, ScriptedAgent
from vehicle_agent.link.counters import LinkCounters
from vehicle_agent.ports import Action, ActionResult, AutopilotText, Inbox, Outbox, ReturnHome, VehicleState
from vehicle_agent.runtime import Runtime, VehicleClock
from vehicle_agent.wire.messages import Event, Severity, Stage

START_MS = 1_767_225_600_000


class Trial:
    """A runtime on played ports, with a wall clock that the test turns."""

    def __init__(self, agent: ScriptedAgent | None = None, folder: Path | None = None) -> None:
        self.wall_s = 100.0
        self.ports = PlayedPorts()
        self.agent = agent or ScriptedAgent()
        self.clock = VehicleClock()
        self.runtime = Runtime(
            "merlin",
            self.agent,
            self.ports.autopilot,
            self.ports.team,
            self.ports.payload,
            self.ports,  # type: ignore[arg-type]
            clock=self.clock,
            counters=lambda: self.ports.counters,
            folder=folder,
            wall_clock=lambda: self.wall_s,
        )

    def state(self, after_s: float) -> VehicleState:
        return VehicleState(stamp_ms=START_MS + round(after_s * 1000), position_enu_m=(0.0, 0.0, 0.0))


def event() -> Event:
    return Event(sender="merlin", boot_id=1, sequence=1, stamp_ms=1, severity=Severity.INFO, code="took-off", text="up")


def test_it_steps_at_every_new_state_and_in_the_vehicles_time() -> None:
    trial = Trial()
    assert not trial.runtime.turn()
    for after_s in (0.0, 0.2, 0.4):
        trial.ports.states.append(trial.state(after_s))
        trial.wall_s += 0.02
        assert trial.runtime.turn()
        assert not trial.runtime.turn()
    assert [round(now_s - START_MS / 1000, 3) for now_s, _ in trial.agent.steps] == [0.0, 0.2, 0.4]


def test_before_the_first_state_nothing_is_stepped_and_nothing_is_lost() -> None:
    trial = Trial()
    trial.ports.texts.append(AutopilotText(6, "ArduCopter"))
    trial.ports.messages.append(event())
    trial.wall_s += 60.0
    assert not trial.runtime.turn()
    trial.ports.results.append(ActionResult(1, True))
    trial.ports.states.append(trial.state(0.0))
    assert trial.runtime.turn()
    inbox = trial.agent.steps[0][1]
    assert (len(inbox.texts), len(inbox.messages), len(inbox.results)) == (1, 1, 1)


def test_with_a_silent_autopilot_it_goes_on_stepping_and_time_goes_on_but_never_back() -> None:
    trial = Trial()
    trial.ports.states.append(trial.state(10.0))
    trial.runtime.turn()
    for _ in range(40):
        trial.wall_s += 0.25
        trial.runtime.turn()
    trial.ports.states.append(trial.state(10.2))  # it was silent, but its time had stood still
    trial.runtime.turn()
    times = [now_s - START_MS / 1000 for now_s, _ in trial.agent.steps]
    assert len(times) == 22
    assert times == sorted(times)
    assert times[-1] == pytest.approx(10.0 + 10.0 - 0.5)
    assert trial.agent.steps[1][1].state is None


def test_it_journals_before_it_acts_and_acts_before_it_speaks() -> None:
    action = Action(1, ReturnHome())
    outbox = Outbox(journal=[b"seen"], actions=[action], messages=[event()])
    trial = Trial(ScriptedAgent(lambda _now_s, _inbox: outbox))
    trial.ports.states.append(trial.state(0.0))
    trial.runtime.turn()
    assert trial.ports.log == [("journal", b"seen"), ("submit", action), ("publish", event())]


def test_the_agent_knows_what_its_radio_cost() -> None:
    trial = Trial()
    trial.ports.counters = LinkCounters(bytes_sent=1234, undecodable=2, overflowed=3, paced_out=4)
    trial.ports.states.append(trial.state(0.0))
    trial.runtime.turn()
    assert (trial.agent.bytes_sent, trial.agent.messages_dropped) == (1234, 9)


async def test_a_finished_agent_goes_on_and_leaves_its_results(tmp_path: Path) -> None:
    stop, news = asyncio.Event(), asyncio.Event()

    def script(now_s: float, _inbox: Inbox) -> Outbox:
        trial.agent.stage = Stage.DONE
        if now_s >= START_MS / 1000 + 2.0:
            assert (tmp_path / "merlin" / "result.json").exists()
            trial.agent.map.elevation_dm[0, 0] = 7
            stop.set()
        return Outbox()

    trial = Trial(ScriptedAgent(script), tmp_path / "merlin")
    trial.ports.states += [trial.state(float(number)) for number in range(3)]
    await asyncio.wait_for(trial.runtime.run(stop, news), 20.0)
    assert len(trial.agent.steps) == 3
    result = json.loads((tmp_path / "merlin" / "result.json").read_text())
    assert (result["vehicle"], result["stage"], result["steps"]) == ("merlin", "done", 3)
    with np.load(tmp_path / "merlin" / "map.npz") as arrays:
        assert set(arrays) == {"first_stamp_ms", "observers", "elevation_dm"}
        assert arrays["elevation_dm"][0, 0] == 7
    assert sorted(path.name for path in (tmp_path / "merlin").iterdir()) == ["map.npz", "result.json"]


async def test_it_ends_by_itself_when_asked_to(tmp_path: Path) -> None:
    def script(_now_s: float, _inbox: Inbox) -> Outbox:
        trial.agent.stage = Stage.DONE
        return Outbox()

    trial = Trial(ScriptedAgent(script), tmp_path)
    trial.ports.states.append(trial.state(0.0))
    await asyncio.wait_for(trial.runtime.run(asyncio.Event(), asyncio.Event(), exit_when_done=True), 20.0)
    assert (tmp_path / "map.npz").exists()
