"""The `missions bench` commands: the numbers in the README come from these."""

from __future__ import annotations

import sys
from pathlib import Path

import click

SEED = click.option("--seed", type=click.IntRange(0, 2**32 - 1), default=1, show_default=True, help="First seed.")
JSON = click.option("--json", "json_file", type=click.Path(path_type=Path, dir_okay=False), help="Write the rows here.")


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
