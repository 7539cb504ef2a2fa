"""The `sim-bridge` program: one process that carries all simulated vehicles of a mission."""

from __future__ import annotations

import asyncio
import signal
import sys
import time
from pathlib import Path

import click
import msgspec

from sim_bridge.fleet import Fleet
from sim_bridge.kernels import warm_up
from sim_bridge.payload import PARTICIPANT, Payload
from sim_bridge.result import result_of, write_result
from sim_bridge.server import Server, ServerError
from sim_bridge.world import World
from vehicle_agent.link.session import FleetLink, LinkError
from vehicle_agent.mission.load import MissionError, MissionPlan, load_mission
from vehicle_agent.mission.model import Mission


@click.command()
@click.argument("mission", type=click.Path(path_type=Path))
@click.option("--speedup", type=click.FloatRange(0, 100, min_open=True), help="Simulated seconds per second.")
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), help="Another seed than the mission's.")
@click.option(
    "--run-dir",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for sim_result.json; left out, none is written.",
)
@click.option("--mavlink-port", type=click.IntRange(1024, 65000), help="First MAVLink port.")
@click.option("--zenoh-port", type=click.IntRange(1024, 65000), help="First Zenoh port.")
def main(
    mission: Path,
    speedup: float | None,
    seed: int | None,
    run_dir: Path | None,
    mavlink_port: int | None,
    zenoh_port: int | None,
) -> None:
    """Simulate the vehicles of MISSION: MAVLink on UDP and TCP per vehicle, sensors on Zenoh.

    Prints `ready` when it serves. SIGTERM and Ctrl-C end it.
    """

    def change(content: Mission) -> Mission:
        simulation, radio = content.simulation, content.radio
        if speedup is not None:
            simulation = msgspec.structs.replace(simulation, speedup=speedup)
        if mavlink_port is not None:
            simulation = msgspec.structs.replace(simulation, mavlink_port=mavlink_port)
        if zenoh_port is not None:
            radio = msgspec.structs.replace(radio, zenoh_port=zenoh_port)
        changed_seed = content.seed if seed is None else seed
        return msgspec.structs.replace(content, simulation=simulation, radio=radio, seed=changed_seed)

    try:
        plan = load_mission(mission, change)
        _make_folder(run_dir)
        fleet = Fleet(plan, World.of(plan))
        warm_up()
        asyncio.run(_serve(plan, fleet, run_dir))
    except (MissionError, ServerError, LinkError) as error:
        click.echo(str(error), err=True)
        sys.exit(2)


def _make_folder(run_dir: Path | None) -> None:
    if run_dir is None:
        return
    try:
        run_dir.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ServerError(f"{run_dir}: cannot be made ({error.strerror}); choose another --run-dir") from None


async def _serve(plan: MissionPlan, fleet: Fleet, run_dir: Path | None) -> None:
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, stop.set)
    boot_id = time.time_ns() & 0xFFFFFFFF
    link = FleetLink.open(plan.mission.name, PARTICIPANT, listen=[plan.simulator_endpoint()])
    server = None
    try:
        payload = Payload(fleet, link, boot_id)
        server = Server(fleet, plan.mission.simulation.speedup, payload.tick)
        await server.open()
        click.echo("ready")
        await server.run(stop)
        await server.close()
    finally:
        link.close()
        if run_dir is not None and server is not None:
            write_result(run_dir, result_of(fleet, server.late_ticks))


if __name__ == "__main__":
    main()
