"""The `missions` program: fly missions with real processes, simulate, check and list them."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import click

from missions.bench.cli import bench

SPEEDUP = click.FloatRange(0.0, 100.0, min_open=True)
SEED = click.IntRange(0, 2**32 - 1)
PORT_BASE = click.IntRange(1024, 64_000)
MAX_SEEDS = 100_000
MISSION = click.argument("mission", metavar="FILE_OR_NAME")


class _Group(click.Group):
    """Turns what a user can mend into one sentence on standard error and exit code 2."""

    def invoke(self, ctx: click.Context) -> Any:
        from vehicle_agent.mission.load import MissionError

        try:
            return super().invoke(ctx)
        except MissionError as error:
            print(f"missions: {error}", file=sys.stderr)
            ctx.exit(2)


@click.group(cls=_Group, context_settings={"help_option_names": ["-h", "--help"]})
def main() -> None:
    """Missions for fleets of unmanned vehicles."""


main.add_command(bench)


@main.command()
@MISSION
@click.option("--plain", is_flag=True, help="Lines instead of the dashboard; chosen by itself without a terminal.")
@click.option("--speedup", type=SPEEDUP, help="Simulated seconds per second (default: as in the mission).")
@click.option("--seed", type=SEED, help="Seed of every random draw (default: as in the mission).")
@click.option("--port-base", type=PORT_BASE, metavar="P", help="Zenoh ports from P on, MAVLink ports from P + 100 on.")
@click.option("--runs-dir", type=click.Path(path_type=Path), default=Path("runs"), show_default=True)
def run(
    mission: str, plain: bool, speedup: float | None, seed: int | None, port_base: int | None, runs_dir: Path
) -> None:
    """Fly a mission with real processes: simulator, one agent per vehicle, ground station.

    Exit code 0 when at least 99 % of the reachable surface was observed and every vehicle is home and disarmed, 1 when
    not, 2 when the mission cannot be flown, 130 after Ctrl-C.
    """
    from missions.catalogue import load_named_mission
    from missions.flown import Changes
    from missions.run import run_mission

    plan = load_named_mission(mission, Changes(speedup, seed, port_base).apply)
    sys.exit(run_mission(plan, runs_dir, plain))


@main.command("list")
def list_missions() -> None:
    """List the missions that come with the package."""
    from missions.catalogue import built_in_missions
    from missions.describe import one_line
    from vehicle_agent.mission.load import load_mission

    for path in built_in_missions().values():
        print(one_line(load_mission(path)))


@main.command()
@MISSION
def check(mission: str) -> None:
    """Check a mission file and its terrain, and tell what it will do."""
    from missions.catalogue import load_named_mission
    from missions.describe import description
    from missions.processes import simulated_names
    from missions.yardstick import observable
    from sim_bridge.world import World

    plan = load_named_mission(mission)
    if not simulated_names(plan):
        print(description(plan, None, None))
        return
    world = World.of(plan)
    print(description(plan, world.elevation_m, observable(plan, world)))


class _SeedRange(click.ParamType[tuple[int, ...]]):
    """`7`, `1-20`, or several of these separated by commas."""

    name = "seeds"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, ...]:
        seeds: list[int] = []
        for part in str(value).split(","):
            match = re.fullmatch(r"(\d{1,10})(?:-(\d{1,10}))?", part, re.ASCII)
            if match is None:
                self.fail(f"{value!r} is not like 7, 1-20 or 1,3,5-8", param, ctx)
            low, high = int(match[1]), int(match[2] or match[1])
            if not low <= high < 2**32 or high - low >= MAX_SEEDS:
                self.fail(f"{part} must rise, stay below 2**32 and hold at most {MAX_SEEDS} seeds", param, ctx)
            seeds += range(low, high + 1)
        return tuple(dict.fromkeys(seeds))


@main.command()
@MISSION
@click.option("--seed", type=SEED, help="Seed of every random draw (default: as in the mission).")
@click.option("--seeds", type=_SeedRange(), help="Several seeds, e.g. 1-20: a line each, and the worst.")
@click.option("--planner", help="Another planner than the mission's.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for the result files.")
@click.option("--jobs", type=click.IntRange(1, 256), default=1, show_default=True, help="Processes for --seeds.")
def simulate(
    mission: str, seed: int | None, seeds: tuple[int, ...] | None, planner: str | None, out: Path | None, jobs: int
) -> None:
    """Fly a mission in one process on simulated time, with the very same agents and no sockets.

    Exit code 0 when every seed observed at least 99 % of the reachable surface, kept 5 m apart and stayed inside the
    fence; 1 when not.
    """
    from missions.sweep import simulate_seeds

    if seed is not None and seeds is not None:
        raise click.UsageError("--seed and --seeds exclude each other; give one of them")
    sys.exit(simulate_seeds(mission, seeds or (seed,), planner, out, jobs))


@main.command()
def schema() -> None:
    """Print the JSON Schema of the mission file."""
    import json

    from vehicle_agent.mission.load import mission_schema

    print(json.dumps(mission_schema(), indent=2))


@main.command()
@click.argument("run_folder", metavar="RUN", type=click.Path(path_type=Path))
def report(run_folder: Path) -> None:
    """Print the summary of a run folder again."""
    from missions.summary import read_summary, summary_text

    print(summary_text(read_summary(run_folder), run_folder))


if __name__ == "__main__":
    main()
