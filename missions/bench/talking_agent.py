"""One agent that only talks, as a process of its own on a real link: something to kill and to cut off.

`python -m missions.bench.talking_agent MISSION INDEX BOOT_ID BASE_S` says what a vehicle says until its standard input
closes. It prints `ready` once it can be heard.
"""

from __future__ import annotations

import select
import sys
import time
from pathlib import Path

from missions.bench.talking_fleet import TalkingLink
from vehicle_agent.link.session import FleetLink
from vehicle_agent.mission.load import load_mission

TICK_S = 0.05


def main(mission: str, index: int, boot_id: int, base_s: int) -> None:
    """Talk once a second of the wall's clock, counted from `base_s`."""
    plan = load_mission(Path(mission))
    link = FleetLink.open(plan.mission.name, plan.vehicle_names[index], listen=[plan.agent_endpoint(index)])
    link.declare_alive()
    voice = TalkingLink(plan, boot_id=boot_id)
    print("ready", flush=True)
    said = 0
    while not select.select([sys.stdin], [], [], TICK_S)[0]:
        second = int(time.time() - base_s - index / len(plan.vehicle_names))
        if second > said:
            said = second
            for message in voice.say(index, second):
                link.publish(message)
    link.close()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]))
