"""Zenoh's threads only put bytes into a queue: what is drawn is touched by the dashboard's own thread alone."""

from __future__ import annotations

import threading
import time
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from ground_station import station as station_module
from ground_station.app import GroundStationApp
from ground_station.link import open_link
from ground_station.station import Station
from ground_station.views.ink import Look
from ground_station.widgets.lines import Lines
from missions.bench.detection import free_ports
from missions.bench.talking_fleet import TalkingLink, mission_text
from vehicle_agent.link.receiving import ReceiveQueue
from vehicle_agent.link.session import FleetLink
from vehicle_agent.mission.load import load_mission


async def test_no_zenoh_callback_touches_a_widget(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    touched: dict[str, set[int]] = {"widget": set(), "picture": set(), "queue": set()}

    def watch(owner: Any, name: str, what: str) -> None:
        genuine = getattr(owner, name)

        def watched(*args: Any, **kwargs: Any) -> Any:
            touched[what].add(threading.get_ident())
            return genuine(*args, **kwargs)

        monkeypatch.setattr(owner, name, watched)

    for name in ("show", "refresh", "render_line"):
        watch(Lines, name, "widget")
    watch(station_module, "fold", "picture")
    watch(ReceiveQueue, "put", "queue")
    file = tmp_path / "mission.toml"
    file.write_text(mission_text(2, free_ports(3)))
    plan = load_mission(file)
    agents = [
        FleetLink.open(plan.mission.name, name, listen=[plan.agent_endpoint(index)])
        for index, name in enumerate(plan.vehicle_names)
    ]
    for agent in agents:
        agent.declare_alive()
    station = Station(plan, "station-0001", 1, time.monotonic())
    app = GroundStationApp(station, partial(open_link, plan, "station-0001"), Look())
    voice, second = TalkingLink(plan), 0
    async with app.run_test(size=(80, 24)) as pilot:
        while station.state.log_total < 4 or station.state.team_map.coverage == 0.0:
            second += 1
            assert second < 600, "the fleet was not heard"
            for index, agent in enumerate(agents):
                for message in voice.say(index, second):
                    agent.publish(message)
            await pilot.pause(0.05)
    station.close()
    for agent in agents:
        agent.close()
    ours = {threading.get_ident()}
    assert touched["widget"] == ours
    assert touched["picture"] == ours
    assert touched["queue"]
    assert not touched["queue"] & ours
