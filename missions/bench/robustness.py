"""Sends millions of hostile frames to simulated vehicles, one open and one that wants signatures."""

from __future__ import annotations

import os
import random
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click
import msgspec

from missions.bench.interview import STEP_S, dialect
from missions.bench.mutations import Mutations
from missions.bench.results import save_rows
from missions.memory import proportional_set_bytes
from sim_bridge.autopilot.node import Node
from sim_bridge.autopilot.service import Client
from sim_bridge.fleet import Fleet
from sim_bridge.reply import StatusText
from sim_bridge.world import World
from vehicle_agent.mission.load import MissionPlan

FRAMES_PER_STEP = 50
SIGNED_EVERY = 20_000
"""Frames between two commands of the controller who knows the key."""
MOST_GROWTH_BYTES = 20_000_000
LONGEST_S = 2.0
"""A burst of frames that takes longer than this counts as a hang."""
WARM_UP_SHARE = 0.2
KEY = bytes(range(32))
SIGNED = 1
"""MAVLink 2's flag for frames with a signature."""


@dataclass
class Report:
    """What happened to one vehicle.

    Attributes
    ----------
    refused
        Frames that the parser counted as wrong.
    obeyed
        Frames without a valid new signature that the signing vehicle acted on.
    longest_s
        Processor time of the slowest burst of `FRAMES_PER_STEP` frames with the step after it.
    served
        Whether it still answers its controller.
    first_exception, first_obeyed
        The frame that did it, or, of a change of state, what changed during which frames and what the vehicle said.
    """

    vehicle: str
    frames: int
    refused: int = 0
    exceptions: int = 0
    obeyed: int = 0
    longest_s: float = 0.0
    growth_bytes: int = 0
    served: bool = False
    first_exception: str = field(default="", compare=False)
    first_obeyed: str = field(default="", compare=False)

    @property
    def passes(self) -> bool:
        return (
            self.served
            and self.exceptions == self.obeyed == 0
            and self.longest_s < LONGEST_S
            and self.growth_bytes < MOST_GROWTH_BYTES
        )


def bench_robustness(plan: MissionPlan, frames: int, seed: int, json_file: Path | None) -> int:
    """Print what the frames did; exit code 0 when nothing went wrong."""
    reports = []
    with click.progressbar(length=frames, label="hostile frames") as bar:
        for name, attack in (("open", attack_open), ("signing", attack_signing)):
            reports.append(attack(plan, frames // 2, random.Random(f"{seed} {name}"), bar.update))
    print("vehicle       frames   refused exceptions obeyed   longest    memory")
    for report in reports:
        print(
            f"{report.vehicle:10s} {report.frames:9d} {report.refused:9d} {report.exceptions:10d} {report.obeyed:6d} "
            f"{report.longest_s * 1e3:6.0f} ms {report.growth_bytes / 1e6:+6.1f} MB  "
            f"{'still answers' if report.served else 'ANSWERS NO MORE'}"
        )
        if report.first_exception:
            print(f"first exception: {report.first_exception}")
        if report.first_obeyed:
            print(f"first obeyed: {report.first_obeyed}")
    if json_file is not None:
        save_rows(json_file, "robustness", seed, [msgspec.to_builtins(report) for report in reports])
    return 0 if all(report.passes for report in reports) else 1


class Target:
    """One vehicle in the air, and a controller that may know a key."""

    def __init__(self, plan: MissionPlan) -> None:
        self.fleet = Fleet(plan, World.of(plan))
        self.vehicle = self.fleet.vehicles[0]
        # An empty battery would change the flight mode without anybody's command.
        self.vehicle.battery.endurance_s = 1e9
        self.node = Node(self.vehicle, plan.datum)
        self.attacker = self.node.connect()
        self.controller = self.node.connect()
        self.voice = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
        self.ears = dialect.MAVLink(None)
        self.ears.robust_parsing = True

    def use_key(self) -> None:
        """Give the vehicle the key and sign from now on."""
        setup = dialect.MAVLink_setup_signing_message(self.node.system_id, 1, list(KEY), 1)
        self.node.receive(self.controller, setup.pack(self.voice))
        for codec in (self.voice, self.ears):
            codec.signing.secret_key = KEY
        self.voice.signing.sign_outgoing = True
        self.voice.signing.timestamp = 1_000

    def lift_off(self) -> None:
        while not self.vehicle.arm().accepted:
            self.pass_time()
        self.vehicle.take_off(20.0)
        while self.vehicle.landed_state != dialect.MAV_LANDED_STATE_IN_AIR:
            self.pass_time()
        self.node.take_output(self.attacker)
        self.node.take_output(self.controller)

    def pass_time(self) -> None:
        self.fleet.step(STEP_S)
        self.node.tick()

    def reconnect(self) -> None:
        """After a reboot every client has to come again."""
        if self.attacker not in self.node.clients:
            self.attacker, self.controller = self.node.connect(), self.node.connect()

    def ask(self) -> tuple[bytes, bool]:
        """Let the controller ask something; returns the frame and whether it was answered."""
        self.reconnect()
        self.node.take_output(self.controller)
        question = dialect.MAVLink_command_long_message(self.node.system_id, 1, 512, 0, 148, 0, 0, 0, 0, 0, 0)
        frame = bytes(question.pack(self.voice))
        self.node.receive(self.controller, frame)
        heard = self.ears.parse_buffer(self.node.take_output(self.controller)) or ()
        return frame, any(message.get_type() == "AUTOPILOT_VERSION" for message in heard)

    def state(self) -> dict[str, Any]:
        """What commands, parameters and missions change, by name."""
        vehicle = self.vehicle
        plan = vehicle.flight_plan
        return {
            **{name: vehicle.parameters[name] for name in vehicle.parameters},
            "mode": vehicle.mode,
            "armed": vehicle.armed,
            "home": vehicle.home_enu_m,
            "mission": plan.mission,
            "fence": plan.fence,
            "rally": plan.rally,
            "signing": (self.node.signing.secret_key, self.node.signing.sign_outgoing),
        }


def _bombard(
    target: Target, report: Report, next_frame: Callable[[int], bytes], look: Callable[[int], None],
    progress: Callable[[int], None],
) -> None:  # fmt: skip
    """Send the frames, step by step; `look` is called after every step with the number of frames so far."""
    baseline = 0
    for number in range(0, report.frames, FRAMES_PER_STEP):
        target.reconnect()
        began_s = time.process_time()
        for offset in range(FRAMES_PER_STEP):
            frame = next_frame(number + offset)
            try:
                target.node.receive(target.attacker, frame)
            except Exception as error:  # noqa: BLE001  any exception at all is what is looked for, and is reported
                report.exceptions += 1
                report.first_exception = report.first_exception or f"{error!r} for {frame.hex()}"
        target.pass_time()
        report.longest_s = max(report.longest_s, time.process_time() - began_s)
        look(number)
        target.node.take_output(target.attacker)
        target.node.take_output(target.controller)
        if not baseline and number >= WARM_UP_SHARE * report.frames:
            baseline = proportional_set_bytes((os.getpid(),))
        progress(FRAMES_PER_STEP)
    report.growth_bytes = proportional_set_bytes((os.getpid(),)) - baseline
    report.refused = target.node.garbled


def attack_open(plan: MissionPlan, frames: int, rng: random.Random, progress: Callable[[int], None]) -> Report:
    """Attack a vehicle that believes everybody; it may do what well-formed frames say, but must live."""
    target, report = Target(plan), Report("open", frames)
    target.lift_off()
    # Whoever takes the key along would only make the rest of the attack harmless.
    without = frozenset({dialect.MAVLINK_MSG_ID_SETUP_SIGNING})
    mutations = Mutations(rng, target.node.system_id, target.node.commands, without)
    _bombard(target, report, lambda number: mutations.frame(), lambda number: None, progress)
    report.served = target.ask()[1] or target.ask()[1]
    return report


def attack_signing(plan: MissionPlan, frames: int, rng: random.Random, progress: Callable[[int], None]) -> Report:
    """Attack a vehicle that wants signatures, with frames without, with forged ones, and with replayed ones."""
    target, report = Target(plan), Report("signing", frames)
    target.use_key()
    target.lift_off()
    mutations = Mutations(rng, target.node.system_id, target.node.commands)
    signed: list[bytes] = [target.ask()[0]]
    before = target.state()
    answered = True
    sent: list[bytes] = []
    said: list[StatusText] = []
    target.node.text_listeners.append(said.append)

    def next_frame(number: int) -> bytes:
        frame = hostile()
        sent.append(frame)
        return frame

    def hostile() -> bytes:
        choice = rng.randrange(3)
        if choice == 0:
            return bytes(rng.choice(signed))
        if choice == 1:
            return _forged(mutations.intact(), rng)
        return mutations.frame()

    def look(number: int) -> None:
        nonlocal answered, before
        heard = _heard(target, target.attacker)
        obeyed = [str(message) for message in heard if message.get_type() in ANSWERS]
        state = target.state()
        if state != before:
            changed = ", ".join(
                f"{name} {before[name]} -> {value}" for name, value in state.items() if value != before[name]
            )
            obeyed.append(f"{changed}; it said {[status.text for status in said]}")
        before = state
        if obeyed and not report.obeyed:
            report.first_obeyed = f"{obeyed[0]} after one of {[frame.hex() for frame in sent]}"
        report.obeyed += len(obeyed)
        said.clear()
        sent.clear()
        if number % SIGNED_EVERY == 0:
            frame, answer = target.ask()
            signed.append(frame)
            del signed[:-20]
            answered = answered and answer

    _bombard(target, report, next_frame, look, progress)
    report.served = answered and target.ask()[1]
    return report


ANSWERS = frozenset(
    {"COMMAND_ACK", "PARAM_VALUE", "MISSION_ACK", "MISSION_COUNT", "MISSION_REQUEST", "AUTOPILOT_VERSION"}
)


def _heard(target: Target, client: Client) -> list[Any]:
    return target.ears.parse_buffer(target.node.take_output(client)) or []


def _forged(frame: bytes, rng: random.Random) -> bytes:
    """The frame with a signature that the key did not make, and a time in the future."""
    flagged = bytearray(frame[:-2])
    flagged[2] = SIGNED
    kind = dialect.mavlink_map[int.from_bytes(flagged[7:10], "little")]
    crc = int(dialect.x25crc(bytes(flagged[1:]) + bytes((kind.crc_extra,))).crc)
    stamp = rng.randrange(1 << 40).to_bytes(6, "little")
    return bytes(flagged) + crc.to_bytes(2, "little") + bytes((rng.randrange(2),)) + stamp + rng.randbytes(6)
