"""The `vehicle-agent` program: one vehicle's agent over MAVLink and Zenoh."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import click
import msgspec
import numpy as np

from vehicle_agent.adapters.ardupilot import COPTER, FIRMWARES
from vehicle_agent.adapters.file_journal import FileJournal, JournalError, JournalHeader
from vehicle_agent.adapters.mavsdk_autopilot import AutopilotError, MavsdkAutopilot
from vehicle_agent.adapters.poor_radio import SPAWN_KEY, PoorRadio, is_poor
from vehicle_agent.adapters.simulated_ranging import SimulatedRanging
from vehicle_agent.adapters.zenoh_payload import ZenohPayload, unpacker
from vehicle_agent.adapters.zenoh_team import ZenohTeam
from vehicle_agent.crew import make_agent
from vehicle_agent.crew import warm_up as warm_up_for
from vehicle_agent.domain.kernels import warm_up
from vehicle_agent.link.session import FleetLink, LinkError
from vehicle_agent.link.tls import TlsFiles
from vehicle_agent.mission.load import MissionError, MissionPlan, check_task, load_mission
from vehicle_agent.mission.model import Mission
from vehicle_agent.mission.tasks import MapTask
from vehicle_agent.mission.vehicles import SingleBeamSensor
from vehicle_agent.ports import Team, TeammateRange
from vehicle_agent.runtime import Runtime, VehicleClock
from vehicle_agent.wire.messages import AnyMessage, Stage

RANGES_KEY = 2_200

_log = logging.getLogger(__name__)


@click.command()
@click.argument("mission", type=click.Path(path_type=Path))
@click.option("--vehicle", required=True, help="Name of the vehicle in the mission file.")
@click.option(
    "--run-dir",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("runs/by-hand"),
    show_default=True,
    help="Folder whose VEHICLE/ keeps journal, map and result.",
)
@click.option("--connection", help="MAVSDK connection URL of the autopilot, instead of the mission file's.")
@click.option("--zenoh-port", type=click.IntRange(1024, 65000), help="First Zenoh port, as radio.zenoh_port.")
@click.option("--mavlink-port", type=click.IntRange(1024, 65000), help="First simulated MAVLink port.")
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), help="Another seed than the mission's.")
@click.option("--exit-when-done", is_flag=True, help="End after landing instead of mending others' maps.")
def main(
    mission: Path,
    vehicle: str,
    run_dir: Path,
    connection: str | None,
    zenoh_port: int | None,
    mavlink_port: int | None,
    seed: int | None,
    exit_when_done: bool,
) -> None:
    """Fly VEHICLE of MISSION.

    Prints `ready` when the radio is up; waits a minute for the autopilot. SIGTERM and Ctrl-C end it; a vehicle in the
    air is then brought home by its own failsafe.
    """

    def change(content: Mission) -> Mission:
        simulation, radio = content.simulation, content.radio
        if mavlink_port is not None:
            simulation = msgspec.structs.replace(simulation, mavlink_port=mavlink_port)
        if zenoh_port is not None:
            radio = msgspec.structs.replace(radio, zenoh_port=zenoh_port)
        changed_seed = content.seed if seed is None else seed
        return msgspec.structs.replace(content, simulation=simulation, radio=radio, seed=changed_seed)

    logging.basicConfig(stream=sys.stderr, level=logging.INFO, format="%(asctime)s %(levelname)s %(message)s")
    try:
        plan = load_mission(mission, change)
        check_task(plan)
        index = plan.index_of(vehicle)
        warm_up()
        warm_up_for(plan)
        asyncio.run(_fly(plan, index, run_dir / vehicle, connection or plan.connection(index), exit_when_done))
    except (MissionError, LinkError, JournalError, AutopilotError) as error:
        click.echo(str(error), err=True)
        sys.exit(2)
    except OSError as error:
        click.echo(f"{error.filename or run_dir}: {error.strerror}; correct --run-dir", err=True)
        sys.exit(2)


async def _fly(plan: MissionPlan, index: int, folder: Path, connection: str, exit_when_done: bool) -> None:
    """Open the ports, run the agent, close them again."""
    name = plan.vehicle_names[index]
    stop, news = asyncio.Event(), asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, stop.set)
    with ExitStack() as opened:
        journal = FileJournal.open(folder / "journal.bin", JournalHeader.of(plan, name))
        opened.callback(journal.close)
        rng = np.random.default_rng(np.random.SeedSequence(plan.mission.seed, spawn_key=(index,)))
        boot_id = int.from_bytes(os.urandom(4), "little")
        agent = make_agent(plan, index, boot_id, rng, journal.records())
        clock = VehicleClock()
        link = FleetLink.open(
            plan.mission.name,
            name,
            listen=[plan.agent_endpoint(index)],
            connect=[plan.agent_endpoint(other) for other in range(index)],
            rate_bytes_s=plan.mission.radio.rate_bytes_s,
            clock=lambda: clock.now_s,
            tls=TlsFiles.of(plan.tls_paths(name)),
        )
        opened.callback(link.close)
        sensor_link = FleetLink.open(plan.mission.name, name, connect=[plan.simulator_endpoint()])
        opened.callback(sensor_link.close)
        payload = ZenohPayload(sensor_link, name, unpacker(plan, index))
        autopilot = MavsdkAutopilot(
            connection,
            plan.system_id(index),
            plan.controller_system_id(index),
            plan.datum,
            firmware=FIRMWARES.get(plan.mission.vehicles[index].type, COPTER),
            sounding_period_s=_sounding_period_s(plan, index),
            wake=_waker(loop, news),
        )
        opened.callback(autopilot.close)
        team = _team(plan, index, link, clock)
        runtime = Runtime(
            name, agent, autopilot, team, payload, journal, clock=clock,
            counters=lambda: link.counters,
            folder=folder, ranges=_ranges(plan, index, opened),
        )  # fmt: skip
        click.echo("ready")
        await runtime.run(stop, news, exit_when_done)
        if isinstance(team, PoorRadio):
            _log.info("radio: %d messages of teammates lost as the mission states, %d heard", team.lost, team.heard)
    if exit_when_done and agent.stage is Stage.REFUSED:
        raise AutopilotError(f"{name}: refused to fly; its last event in the log says why and what to mend")


def _team(plan: MissionPlan, index: int, link: FleetLink, clock: VehicleClock) -> Team:
    """The radio to teammates; between simulated vehicles as poor as the mission states."""
    team, radio, names = ZenohTeam(link), plan.mission.radio, plan.vehicle_names
    if plan.mission.vehicles[index].connection is not None or not is_poor(radio):
        return team
    rng = np.random.default_rng(np.random.SeedSequence(plan.mission.seed, spawn_key=(SPAWN_KEY, index)))
    return PoorRadio(team, radio, [name for name in names if name != names[index]], lambda: clock.now_s, rng)


def _ranges(plan: MissionPlan, index: int, opened: ExitStack) -> Callable[[list[AnyMessage]], list[TeammateRange]]:
    """Distances that come with teammates' packets, between simulated vehicles that map."""
    if not isinstance(plan.mission.task, MapTask) or plan.mission.vehicles[index].connection is not None:
        return lambda _: []
    name = plan.vehicle_names[index]
    link = FleetLink.open(plan.mission.name, name, connect=[plan.simulator_endpoint()])
    opened.callback(link.close)
    rng = np.random.default_rng(np.random.SeedSequence(plan.mission.seed, spawn_key=(RANGES_KEY, index)))
    return SimulatedRanging(link, name, rng).ranges


def _sounding_period_s(plan: MissionPlan, index: int) -> float | None:
    sensor = plan.mission.vehicles[index].sensor
    return sensor.period_s if isinstance(sensor, SingleBeamSensor) else None


def _waker(loop: asyncio.AbstractEventLoop, news: asyncio.Event) -> Callable[[], None]:
    """A call that sets `news` from any thread, and does nothing once the loop has ended."""

    def wake() -> None:
        try:
            loop.call_soon_threadsafe(news.set)
        except RuntimeError:
            return

    return wake


if __name__ == "__main__":
    main()
