"""The `sim-bridge` program: one process that carries all simulated vehicles of a mission."""

from __future__ import annotations

import asyncio
import gc
import signal
import sys
import time
from pathlib import Path

import click
import msgspec

from sim_bridge.control import DEFAULT_ENDPOINT, ControlPort, InjectError, control_port, inject
from sim_bridge.faults import FAULTS
from sim_bridge.fleet import Fleet
from sim_bridge.kernels import warm_up, warm_up_town
from sim_bridge.payload import PARTICIPANT, Payload
from sim_bridge.result import result_of, write_result
from sim_bridge.server import Server, ServerError
from sim_bridge.tlog import TelemetryLog, TelemetryLogError
from sim_bridge.world import World
from vehicle_agent.link.session import FleetLink, LinkError
from vehicle_agent.mission.load import MissionError, MissionPlan, load_mission
from vehicle_agent.mission.model import Mission


class _Program(click.Group):
    """`sim-bridge MISSION ...` serves a mission; other first words are commands of their own."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        asks_for_help = args[:1] in (["--help"], ["-h"])
        if args and args[0] not in self.commands and not asks_for_help:
            args = ["serve", *args]
        return super().parse_args(ctx, args)


@click.group(cls=_Program, context_settings={"help_option_names": ["-h", "--help"]})
def main() -> None:
    """Simulated vehicles: `sim-bridge MISSION` is short for `sim-bridge serve MISSION`."""


@main.command("inject")
@click.argument("vehicle")
@click.argument("fault", type=click.Choice(FAULTS))
@click.option("--off", is_flag=True, help="End the fault instead of beginning it.")
@click.option(
    "--endpoint",
    default=DEFAULT_ENDPOINT,
    show_default=True,
    metavar="HOST:PORT",
    help="Control port of the simulator: the one below its first MAVLink port.",
)
def inject_fault(vehicle: str, fault: str, off: bool, endpoint: str) -> None:
    """Let a FAULT strike a VEHICLE of a running simulator, as a drill."""
    try:
        inject(endpoint, vehicle, fault, not off)
    except InjectError as error:
        click.echo(str(error), err=True)
        sys.exit(2)
    click.echo(f"{vehicle}: {fault} {'over' if off else 'set'}")


@main.command()
@click.argument("mission", type=click.Path(path_type=Path))
@click.option("--speedup", type=click.FloatRange(0, 100, min_open=True), help="Simulated seconds per second.")
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), help="Another seed than the mission's.")
@click.option(
    "--run-dir",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for sim_result.json; left out, none is written.",
)
@click.option(
    "--tlog-dir",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for a MAVLink log per vehicle, VEHICLE.tlog; left out, none is written.",
)
@click.option(
    "--ready-after",
    type=click.FloatRange(0, 600),
    metavar="S",
    help="Simulated seconds until arming is accepted; real autopilots need about 50.",
)
@click.option("--mavlink-port", type=click.IntRange(1024, 65000), help="First MAVLink port.")
@click.option("--zenoh-port", type=click.IntRange(1024, 65000), help="First Zenoh port.")
def serve(
    mission: Path,
    speedup: float | None,
    seed: int | None,
    run_dir: Path | None,
    tlog_dir: Path | None,
    ready_after: float | None,
    mavlink_port: int | None,
    zenoh_port: int | None,
) -> None:
    """Simulate the vehicles of MISSION: MAVLink on UDP and TCP per vehicle, sensors on Zenoh.

    Prints `ready` when it serves. SIGTERM and Ctrl-C end it. The port below the first MAVLink port takes the orders of
    `sim-bridge inject`.
    """

    def change(content: Mission) -> Mission:
        simulation, radio = content.simulation, content.radio
        if speedup is not None:
            simulation = msgspec.structs.replace(simulation, speedup=speedup)
        if ready_after is not None:
            simulation = msgspec.structs.replace(simulation, ready_after_s=ready_after)
        if mavlink_port is not None:
            simulation = msgspec.structs.replace(simulation, mavlink_port=mavlink_port)
        if zenoh_port is not None:
            radio = msgspec.structs.replace(radio, zenoh_port=zenoh_port)
        changed_seed = content.seed if seed is None else seed
        return msgspec.structs.replace(content, simulation=simulation, radio=radio, seed=changed_seed)

    try:
        plan = load_mission(mission, change)
        _make_folder(run_dir, "--run-dir")
        _make_folder(tlog_dir, "--tlog-dir")
        fleet = Fleet(plan, World.of(plan))
        warm_up()
        if plan.voxel_grid is not None:
            warm_up_town()
        asyncio.run(_serve(plan, fleet, run_dir, tlog_dir))
    except (MissionError, ServerError, LinkError, TelemetryLogError) as error:
        click.echo(str(error), err=True)
        sys.exit(2)


def _make_folder(folder: Path | None, option: str) -> None:
    if folder is None:
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ServerError(f"{folder}: cannot be made ({error.strerror}); choose another {option}") from None


def _note(line: str) -> None:
    """Tell what a vehicle refused; standard error is the simulator's log."""
    click.echo(line, err=True)


def _record(plan: MissionPlan, server: Server, folder: Path) -> list[TelemetryLog]:
    """Keep what every simulated vehicle says and hears."""
    logs = []
    for name, table, node in zip(plan.vehicle_names, plan.mission.vehicles, server.nodes, strict=True):
        if table.connection is None:
            log = TelemetryLog(folder / f"{name}.tlog", server.fleet.clock, _note)
            node.record = log.write
            logs.append(log)
    return logs


async def _serve(plan: MissionPlan, fleet: Fleet, run_dir: Path | None, tlog_dir: Path | None) -> None:
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, stop.set)
    boot_id = time.time_ns() & 0xFFFFFFFF
    link = FleetLink.open(plan.mission.name, PARTICIPANT, listen=[plan.simulator_endpoint()])
    server = None
    logs: list[TelemetryLog] = []
    control = ControlPort(fleet)
    try:
        payload = Payload(fleet, link, boot_id)
        server = Server(fleet, plan.mission.simulation.speedup, payload.tick, _note)
        if tlog_dir is not None:
            logs = _record(plan, server, tlog_dir)
        await server.open()
        await _open_control(control, plan, fleet)
        # What has been built so far stays: collecting it again and again would make steps late.
        gc.collect()
        gc.freeze()
        click.echo("ready")
        await server.run(stop)
        await server.close()
    finally:
        control.close()
        for log in logs:
            log.close()
        link.close()
        if run_dir is not None and server is not None:
            write_result(run_dir, result_of(fleet, server.late_ticks))


async def _open_control(control: ControlPort, plan: MissionPlan, fleet: Fleet) -> None:
    """Drills are a convenience: without their port the simulator serves all the same, and says so."""
    host, port = plan.mission.radio.endpoint_host, control_port(fleet)
    try:
        await control.open(host, port)
    except OSError as error:
        click.echo(f"control port {host}:{port} cannot be had ({error.strerror}); `inject` will not work", err=True)


if __name__ == "__main__":
    main()
