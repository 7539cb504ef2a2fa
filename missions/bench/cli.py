"""The `missions bench` commands: the numbers in the README come from these."""

from __future__ import annotations

import sys
from pathlib import Path

import click

SEED = click.option("--seed", type=click.IntRange(0, 2**32 - 1), default=1, show_default=True, help="First seed.")
JSON = click.option("--json", "json_file", type=click.Path(path_type=Path, dir_okay=False), help="Write the rows here.")

EXPORT = click.option(
    "--export", type=click.Path(path_type=Path, file_okay=False), help="Folder for environments and trajectories."
)


MOST_VEHICLES = 64


@click.group()
def bench() -> None:
    """Measure planners, maps and sensors against their rivals."""


@bench.command()
@SEED
@click.option("--scenes", type=click.IntRange(1, 1000), default=5, show_default=True, help="Seeded scenes.")
@click.option("--scans", type=click.IntRange(1, 1000), default=10, show_default=True, help="Scans per scene.")
@JSON
def voxels(seed: int, scenes: int, scans: int, json_file: Path | None) -> None:
    """Insert the same scans into this voxel map and into OctoMap; tell rates, their ratio, and agreement."""
    from missions.bench.voxels import bench_voxels

    sys.exit(bench_voxels(seed, scenes, scans, json_file))


@bench.command()
@JSON
def autopilot(json_file: Path | None) -> None:
    """Tell what simulated autopilots cost in CPU time, and how fast fleets of 1 to 50 can be flown."""
    from missions.bench.autopilot import bench_autopilot

    sys.exit(bench_autopilot(json_file))


@bench.command()
@JSON
def conformance(json_file: Path | None) -> None:
    """Ask the simulated vehicles what real ArduPilot vehicles were asked; tell where the answers agree."""
    from missions.bench.conformance import bench_conformance

    sys.exit(bench_conformance(json_file))


@bench.command()
@click.option(
    "--environments", type=click.IntRange(1, 1000), show_default="100, or 2 with --scaling", help="Random hills."
)
@click.option("--vehicles", type=click.IntRange(1, 64), show_default="8")
@click.option("--range", "range_m", type=click.FloatRange(3.5, 50.0), default=8.0, show_default=True, help="Metres.")
@click.option("--step", "step_m", type=click.FloatRange(0.5, 20.0), default=2.0, show_default=True, help="Metres.")
@click.option("--scaling", is_flag=True, help="Time plans of 2 to 64 vehicles on maps of 100 to 1000 cells a side.")
@SEED
@JSON
@EXPORT
def exploration(
    environments: int | None,
    vehicles: int | None,
    range_m: float,
    step_m: float,
    scaling: bool,
    seed: int,
    json_file: Path | None,
    export: Path | None,
) -> None:
    """Explore random hills with every planner; tell steps, planning time, bytes and overlap."""
    from missions.bench.exploration import bench_exploration
    from missions.bench.exploration_scaling import bench_scaling

    if scaling:
        if vehicles is not None or export is not None:
            raise click.UsageError(
                "--scaling has its own team sizes and exports nothing; leave out --vehicles, --export"
            )
        sys.exit(bench_scaling(environments or 2, range_m, step_m, seed, json_file))
    sys.exit(bench_exploration(environments or 100, vehicles or 8, range_m, step_m, seed, json_file, export))


class _TeamSizes(click.ParamType[tuple[int, ...]]):
    """Numbers of vehicles separated by commas."""

    name = "sizes"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, ...]:
        sizes = [part.strip() for part in str(value).split(",")]
        if not all(size.isascii() and size.isdigit() and 1 <= int(size[:9]) <= MOST_VEHICLES for size in sizes):
            self.fail(f"{value!r} is not like 5,8,12 with numbers from 1 to {MOST_VEHICLES}", param, ctx)
        return tuple(dict.fromkeys(int(size) for size in sizes))


@bench.command()
@click.option("--environments", type=click.IntRange(1, 1000), default=50, show_default=True, help="Random hills.")
@click.option("--vehicles", type=_TeamSizes(), default="5,8,12,20", show_default=True, help="Team sizes.")
@SEED
@JSON
@EXPORT
def coverage(
    environments: int, vehicles: tuple[int, ...], seed: int, json_file: Path | None, export: Path | None
) -> None:
    """Cover random hills from every start with every planner; tell shares covered, and of an informed optimum."""
    from missions.bench.coverage import bench_coverage

    sys.exit(bench_coverage(environments, vehicles, seed, json_file, export))


@bench.command()
@click.option("--environments", type=click.IntRange(1, 1000), default=10, show_default=True, help="Random towns.")
@click.option("--vehicles", type=_TeamSizes(), default="3,5", show_default=True, help="Team sizes.")
@SEED
@JSON
def urban(environments: int, vehicles: tuple[int, ...], seed: int, json_file: Path | None) -> None:
    """Explore random towns, between and around their buildings; tell how long teams take to see all surface."""
    from missions.bench.urban import bench_urban

    sys.exit(bench_urban(environments, vehicles, seed, json_file))


class _Landmarks(click.ParamType[tuple[str, ...]]):
    """Numbers of landmarks separated by commas."""

    name = "landmarks"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        wanted = [part.strip() for part in str(value).split(",")]
        if not all(part in ("1100", "all") for part in wanted):
            self.fail(f"{value!r} is not 1100, all or both with a comma between", param, ctx)
        return tuple(dict.fromkeys(wanted))


class _SeveralVehicles(_TeamSizes):
    """Team sizes of at least two: a radio link needs both ends."""

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, ...]:
        sizes = super().convert(value, param, ctx)
        if min(sizes) < 2:
            self.fail("a team that must keep its radio link needs at least 2 vehicles", param, ctx)
        return sizes


@bench.command()
@click.option("--seeds", type=click.IntRange(1, 1000), default=10, show_default=True, help="Runs of each row.")
@click.option("--vehicles", type=_SeveralVehicles(), default="3,10", show_default=True, help="Team sizes.")
@click.option("--landmarks", type=_Landmarks(), default="1100,all", show_default=True, help="Lattices.")
@SEED
@JSON
@EXPORT
@click.option("--times", is_flag=True, help="Tell planning times by how much of the landmarks is done, too.")
def mapping(
    seeds: int, vehicles: tuple[int, ...], landmarks: tuple[str, ...], seed: int, json_file: Path | None,
    export: Path | None, times: bool,
) -> None:  # fmt: skip
    """Map two surfaces from noisy ranges over a thin link with every method; tell what remains, errors and bytes."""
    from missions.bench.mapping import bench_mapping

    sys.exit(bench_mapping(seeds, vehicles, landmarks, seed, json_file, export, times))


@bench.command()
@click.option("--seeds", type=click.IntRange(1, 1000), default=10, show_default=True, help="Sea floors of each kind.")
@SEED
@click.option("--limits", is_flag=True, help="What tracks could reach that are laid by who knows the floor beforehand.")
@JSON
def bathymetry(seeds: int, seed: int, limits: bool, json_file: Path | None) -> None:
    """Survey sea floors with two vehicles' echo sounders, where it pays and by lines; tell L2 errors of the maps."""
    from missions.bench.bathymetry import bench_bathymetry
    from missions.bench.bathymetry_limits import bench_limits

    sys.exit((bench_limits if limits else bench_bathymetry)(seeds, seed, json_file))


@bench.command()
@click.option("--seeds", type=click.IntRange(1, 1000), default=6, show_default=True, help="Flights of each kind.")
@SEED
@click.option("--over-time", is_flag=True, help="The map on board minute by minute, by what the radio carries.")
@JSON
def harbour(seeds: int, seed: int, over_time: bool, json_file: Path | None) -> None:
    """Simulate the harbour survey with poorer radios and positions, and with what mends them; tell the maps' errors."""
    from missions.bench.harbour import bench_harbour
    from missions.bench.harbour_over_time import bench_harbour_over_time

    sys.exit((bench_harbour_over_time if over_time else bench_harbour)(seeds, seed, json_file))


@bench.command()
@SEED
@click.option("--frames", type=click.IntRange(1_000), default=5_000_000, show_default=True, help="How many.")
@JSON
def robustness(seed: int, frames: int, json_file: Path | None) -> None:
    """Send hostile frames to two simulated vehicles; tell exceptions, hangs, memory, and what was wrongly obeyed."""
    from missions.bench.conformance import three_vehicles
    from missions.bench.robustness import bench_robustness

    sys.exit(bench_robustness(three_vehicles(), frames, seed, json_file))


@bench.command()
@click.option("--seconds", type=click.FloatRange(2.0, 600.0), default=20.0, show_default=True, help="Per case.")
@click.option("--keys", type=click.IntRange(1, 1000), default=40, show_default=True, help="Key presses per case.")
@click.option("--hours", type=click.IntRange(0, 24), default=8, show_default=True, help="Of a simulated mission.")
@JSON
def dashboard(seconds: float, keys: int, hours: int, json_file: Path | None) -> None:
    """Tell what the dashboard sends to a terminal, costs in CPU time and memory, and how soon it answers a key."""
    from missions.bench.dashboard import bench_dashboard

    sys.exit(bench_dashboard(seconds, keys, hours, json_file))


@bench.command()
@click.option("--vehicles", type=click.IntRange(2, MOST_VEHICLES), default=20, show_default=True)
@click.option("--kills", type=click.IntRange(0, 10_000), default=100, show_default=True, help="Agents killed in turn.")
@click.option("--cuts", type=click.IntRange(0, 10_000), default=20, show_default=True, help="Links cut in turn.")
@click.option("--outages", type=click.IntRange(0, 10_000), default=10, show_default=True, help="Of 2 s, of all links.")
@JSON
def detection(vehicles: int, kills: int, cuts: int, outages: int, json_file: Path | None) -> None:
    """Kill agents and cut links, with real processes; tell how soon the dashboard shows it and what it proposes."""
    from missions.bench.detection import bench_detection

    sys.exit(bench_detection(vehicles, kills, cuts, outages, json_file))
