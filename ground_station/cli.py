"""The `ground-station` program: a dashboard on a terminal, a plain line log elsewhere."""

from __future__ import annotations

import io
import os
import secrets
import sys
import time
from functools import partial
from pathlib import Path
from typing import NoReturn

import click
import msgspec

from vehicle_agent.mission.load import MissionError, MissionPlan, load_mission
from vehicle_agent.mission.model import Mission

MIN_START_WIDTH, MIN_START_HEIGHT = 40, 10


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("mission", type=click.Path(path_type=Path))
@click.option("--plain", is_flag=True, help="Write lines instead of drawing; chosen by itself without a terminal.")
@click.option("--ascii", "ascii_only", is_flag=True, help="Use ASCII characters only.")
@click.option("--interval", type=click.FloatRange(0.1), default=5.0, show_default=True,
              help="Seconds between two status lines of --plain.")  # fmt: skip
@click.option("--zenoh-port", type=click.IntRange(1024, 65000), help="Use this radio.zenoh_port instead of the file's.")
@click.option("--notice-file", type=click.Path(path_type=Path), help="Show this file's line until a vehicle is live.")
@click.option("--exit-when-done", is_flag=True, help="End when every vehicle has finished or is lost.")
def main(
    mission: Path,
    plain: bool,
    ascii_only: bool,
    interval: float,
    zenoh_port: int | None,
    notice_file: Path | None,
    exit_when_done: bool,
) -> None:
    """Watch and command the fleet that flies MISSION (a mission file)."""
    try:
        plan = load_mission(mission, partial(_with_port, port=zenoh_port))
    except MissionError as error:
        _refuse(str(error))
    if plain or not all(stream.isatty() for stream in (sys.stdin, sys.stdout, sys.stderr)):
        _plain(plan, ascii_only, interval, notice_file, exit_when_done)
    else:
        _dashboard(plan, ascii_only, notice_file, exit_when_done)


def _with_port(mission: Mission, port: int | None) -> Mission:
    if port is None:
        return mission
    return msgspec.structs.replace(mission, radio=msgspec.structs.replace(mission.radio, zenoh_port=port))


def _plain(
    plan: MissionPlan, ascii_only: bool, interval_s: float, notice_file: Path | None, exit_when_done: bool
) -> None:
    from ground_station.link import open_link, station_name
    from ground_station.plain import run_plain
    from ground_station.station import Station
    from vehicle_agent.link.session import LinkError

    if ascii_only and isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(encoding="ascii", errors="replace")
    name = station_name()
    station = Station(plan, name, secrets.randbits(32), time.monotonic())
    try:
        run_plain(
            station,
            partial(open_link, plan, name),
            interval_s=interval_s,
            notice_file=notice_file,
            exit_when_done=exit_when_done,
        )
    except LinkError as error:
        _refuse(str(error))
    except BrokenPipeError:
        # Whoever read the lines has gone: a second complaint at interpreter exit is avoided by a harmless stdout.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    finally:
        station.close()


def _dashboard(plan: MissionPlan, ascii_only: bool, notice_file: Path | None, exit_when_done: bool) -> None:
    width, height = os.get_terminal_size(sys.stderr.fileno())
    if 0 < width < MIN_START_WIDTH or 0 < height < MIN_START_HEIGHT:
        _refuse(
            f"the terminal has {width}x{height} characters; enlarge it to 80x24 (at least "
            f"{MIN_START_WIDTH}x{MIN_START_HEIGHT}), or use --plain"
        )
    from ground_station.app import GroundStationApp
    from ground_station.link import open_link, station_name
    from ground_station.station import Station
    from ground_station.views.ink import Look

    encoding = (sys.stdout.encoding or "").lower().replace("-", "")
    look = Look(unicode=not ascii_only and encoding == "utf8", colour="NO_COLOR" not in os.environ)
    name = station_name()
    station = Station(plan, name, secrets.randbits(32), time.monotonic())
    app = GroundStationApp(
        station, partial(open_link, plan, name), look, notice_file=notice_file, exit_when_done=exit_when_done
    )
    try:
        app.run()
    finally:
        station.close()
    if app.refusal:
        _refuse(app.refusal)
    sys.exit(app.return_code or 0)


def _refuse(sentence: str) -> NoReturn:
    print(f"ground-station: {sentence}", file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    main()
