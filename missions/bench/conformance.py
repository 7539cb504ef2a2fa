"""Asks the simulated vehicles what real ArduPilot vehicles were asked, and tells where the answers agree."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from missions.bench.golden_answers import Recorded, Reply, recorded_answers, reply_of
from missions.bench.interview import Interview
from missions.bench.questions import Answered, ask_all
from missions.bench.results import save_rows
from sim_bridge.fleet import Fleet
from sim_bridge.world import World
from vehicle_agent.mission.load import MissionPlan, plan_mission
from vehicle_agent.mission.model import Mission

FIRMWARES = {"copter": "multicopter", "rover": "surface-vessel", "sub": "underwater-vehicle"}
"""Names of the recordings, and the type of vehicle each is held against."""
READY_AFTER_S = 50.0
"""The recorded vehicles accepted arming 48 to 56 simulated seconds after their start."""
COMPARED = {
    "AUTOPILOT_VERSION": {"capabilities", "flight_sw_version"},
    "HOME_POSITION": {"q"},
    "TIMESYNC": {"ts1"},
    "LOG_ENTRY": {"id", "num_logs", "last_log_num"},
    "PARAM_VALUE": {"param_id", "param_value", "param_type", "param_index"},
    "STATUSTEXT": {"severity", "text"},
}
"""Fields that neither the place nor the time nor the build decides; of other messages all fields are compared."""
PASSING_TEXTS = ("GPS 1:", "EKF3 ", "AHRS:", "Disarming motors")
"""Said by vehicles that start up, whatever they are asked."""
SLOW_HZ = 0.5
"""Kinds of messages that come less often may be missed in a short count."""
_ACK = r"COMMAND_ACK \{command : 512, result : 0, [^}]*\} \| "
EXPLANATIONS = (
    (
        "REQUEST_MESSAGE AVAILABLE_MODES",
        rf"{_ACK}AVAILABLE_MODES \{{.*mode_index : 1, .*\}}, recorded {_ACK}AVAILABLE_MODES .*",
        "it has fewer flight modes than the real firmware",
    ),
    (
        "PARAM_SET ok",
        r"PARAM_VALUE \{param_id : FS_GCS_TIMEOUT, param_value : 6.0, param_type : 9, param_index : 65535\}, "
        r"recorded PARAM_VALUE \{param_id : MOT_THST_HOVER, .*",
        "the real copter had just stored its hover thrust, and told that first",
    ),
    ("unsolicited in 3s", "GIMBAL_DEVICE_ATTITUDE_STATUS 0 instead of 9", "it carries no gimbal"),
    (
        "HEARTBEAT",
        r"HEARTBEAT \{type : 11, (.*)\}, recorded HEARTBEAT \{type : 10, \1\}",
        "it is a boat (FRAME_CLASS 2), the recorded rover had wheels",
    ),
)
"""Known differences: question, the whole difference as a pattern, and why it is none that matters."""


@dataclass(frozen=True)
class Verdict:
    """How one answer compares: `agrees`, or the difference, which is harmless when it is explained."""

    firmware: str
    question: str
    difference: str
    explanation: str

    @property
    def agrees(self) -> bool:
        return not self.difference

    @property
    def passes(self) -> bool:
        return self.agrees or bool(self.explanation)


def bench_conformance(json_file: Path | None) -> int:
    """Print the comparison question by question; exit code 0 when nothing differs without an explanation."""
    verdicts = {firmware: examine(firmware) for firmware in FIRMWARES}
    questions = [verdict.question for verdict in verdicts["copter"]]
    print(f"{'question':40s} {'copter':>9s} {'boat':>9s} {'sub':>9s}")
    for number, question in enumerate(questions):
        row = [verdicts[firmware][number] for firmware in FIRMWARES]
        print(f"{question[:40]:40s} " + " ".join(f"{_word(verdict):>9s}" for verdict in row))
    flat = [verdict for of_one in verdicts.values() for verdict in of_one]
    for verdict in flat:
        if not verdict.agrees:
            why = f" ({verdict.explanation})" if verdict.explanation else ""
            print(f"{verdict.firmware}: {verdict.question}: {verdict.difference}{why}")
    for firmware, of_one in verdicts.items():
        agreeing, explained = sum(v.agrees for v in of_one), sum(v.passes and not v.agrees for v in of_one)
        print(f"{firmware}: {agreeing} of {len(of_one)} agree, {explained} differ for a known reason")
    if json_file is not None:
        save_rows(json_file, "conformance", 0, [msgspec.to_builtins(verdict) for verdict in flat])
    return 0 if all(verdict.passes for verdict in flat) else 1


def examine(firmware: str) -> list[Verdict]:
    """Ask one vehicle everything and compare with its recording."""
    plan = three_vehicles()
    fleet = Fleet(plan, World.of(plan))
    recorded = recorded_answers(firmware)
    interview = Interview(fleet, list(FIRMWARES).index(firmware))
    return [compare(firmware, answered, recorded[answered.name]) for answered in ask_all(interview)]


def three_vehicles() -> MissionPlan:
    """A copter, a boat and an underwater vehicle with system ids 1, 2 and 3, as those recorded."""
    team = [
        {
            "name": firmware,
            "type": kind,
            "start_enu_m": [100.0 + 50.0 * number, 100.0],
            "speed_m_s": 5.0,
            "sensor": {"kind": "range", "range_m": 100.0},
            "min_above_terrain_m": 5.0,
            "max_above_terrain_m": 100.0,
        }
        for number, (firmware, kind) in enumerate(FIRMWARES.items())
    ]
    content: dict[str, Any] = {
        "format": 1,
        "name": "conformance",
        "seed": 1,
        "datum": {"latitude_deg": 47.39, "longitude_deg": 8.54, "altitude_amsl_m": 488.0},
        "area": {"cell_m": 20.0, "rectangle_enu_m": [0.0, 0.0, 400.0, 400.0]},
        "terrain": {"kind": "flat", "elevation_amsl_m": 468.0},
        "task": {"kind": "explore"},
        "vehicles": team,
        "simulation": {"ready_after_s": READY_AFTER_S},
    }
    return plan_mission(msgspec.convert(content, Mission), Path("conformance"))


def compare(firmware: str, answered: Answered, recorded: Recorded) -> Verdict:
    """Compare one answer with the recorded one."""
    difference = _difference(answered, recorded)
    for question, pattern, reason in EXPLANATIONS:
        if difference and question == answered.name and re.fullmatch(pattern, difference):
            return Verdict(firmware, answered.name, difference, reason)
    return Verdict(firmware, answered.name, difference, "")


def _difference(answered: Answered, recorded: Recorded) -> str:
    if answered.counts is not None:
        if answered.name == "heartbeats in 3.2s":
            return "" if 3 <= answered.counts["HEARTBEAT"] <= 5 else f"{answered.counts['HEARTBEAT']} heartbeats"
        return _rate_difference(answered, recorded)
    if answered.name == "PARAM_REQUEST_LIST":
        told, count = answered.text.split("/")
        return "" if told == count else f"only {answered.text} parameters"
    if answered.text:
        return "" if recorded.text.split()[-1] == answered.text else f"{answered.text}, recorded {recorded.text}"
    ours = _essence(reply for message in answered.messages if (reply := reply_of(str(message))) is not None)
    theirs = _essence(recorded.replies)
    if answered.name == "DO_SEND_BANNER":
        ours, theirs = ours[:2], theirs[:2]
    elif answered.name == "...no answer for 13s":
        ours = [reply for reply in ours if reply.kind.startswith("MISSION")]
        theirs = [reply for reply in theirs if reply.kind.startswith("MISSION")]
        missing = [reply for reply in theirs if not any(_same(other, reply) for other in ours)]
        return f"without {missing[0]}" if missing else ""
    agree = len(ours) == len(theirs) and all(map(_same, ours, theirs))
    return "" if agree else f"{_told(ours)}, recorded {_told(theirs)}"


def _rate_difference(answered: Answered, recorded: Recorded) -> str:
    """Kinds that are missing, superfluous on a silent vehicle, or more than twice too fast or too slow."""
    assert answered.counts is not None
    seconds = 1.0 if answered.name == "unsolicited in 3s" else 4.0
    problems = []
    for kind, rate in recorded.rates.items():
        ours = answered.counts[kind] / seconds
        if kind != "STATUSTEXT" and rate >= SLOW_HZ and not rate / 2.0 <= ours <= rate * 2.0:
            problems.append(f"{kind} {ours:g} instead of {rate:g}")
    if set(recorded.rates) == {"HEARTBEAT"}:
        problems += [f"{kind} unasked" for kind in answered.counts if kind not in ("HEARTBEAT", "STATUSTEXT")]
    return ", ".join(problems)


def _essence(replies: Iterable[Reply]) -> list[Reply]:
    """Replies without passing texts, repetitions and fields that do not count."""
    kept: list[Reply] = []
    for reply in replies:
        wanted = COMPARED.get(reply.kind)
        fields = {name: value for name, value in reply.fields.items() if wanted is None or name in wanted}
        if reply.kind == "STATUSTEXT":
            if fields.get("text", "").startswith(PASSING_TEXTS):
                continue
            fields["text"] = fields.get("text", "").partition(" (")[0]
        essence = Reply(reply.kind, fields)
        if not kept or kept[-1] != essence:
            kept.append(essence)
    return kept


def _same(ours: Reply, theirs: Reply) -> bool:
    """Whether the recorded fields, which may have been cut off, are ours."""
    return ours.kind == theirs.kind and all(ours.fields.get(name) == value for name, value in theirs.fields.items())


def _told(replies: list[Reply]) -> str:
    return " | ".join(map(str, replies)) or "silence"


def _word(verdict: Verdict) -> str:
    if verdict.agrees:
        return "agrees"
    return "explained" if verdict.explanation else "DIFFERS"
