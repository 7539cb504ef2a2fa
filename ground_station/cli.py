"""The `ground-station` program: a dashboard on a terminal or in a browser, a plain line log elsewhere, and replays."""

from __future__ import annotations

import io
import os
import secrets
import sys
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import click
import msgspec

from vehicle_agent.mission.load import MissionError, MissionPlan, load_mission
from vehicle_agent.mission.model import Mission

if TYPE_CHECKING:
    from ground_station.player import Player
    from ground_station.station import Station
    from ground_station.views.ink import Look

MIN_START_WIDTH, MIN_START_HEIGHT = 40, 10
LOW_BANDWIDTH_PERIOD_S = 1.5
WEB_DRIVER = "TEXTUAL_DRIVER"
"""Set by textual-serve in the dashboards that it starts: a browser stands in the place of a terminal."""


@dataclass(frozen=True, slots=True)
class Options:
    """How the fleet is shown; see the options of `main`."""

    ascii_only: bool
    interval_s: float
    notice_file: Path | None
    exit_when_done: bool
    stops_mission: bool
    low_bandwidth: bool
    theme: str
    endpoints: tuple[str, ...]
    mavlink: tuple[str, ...]
    record: Path | None


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("mission", type=click.Path(path_type=Path), required=False)
@click.option("--plain", is_flag=True, help="Write lines instead of drawing; chosen by itself without a terminal.")
@click.option("--ascii", "ascii_only", is_flag=True, help="Use ASCII characters only.")
@click.option("--low-bandwidth", is_flag=True, help="For thin links: draw less often, in 16 colours, nothing moves.")
@click.option("--theme", type=click.Choice(["night", "day", "mono"]), default="night", show_default=True)
@click.option("--interval", type=click.FloatRange(0.1), default=5.0, show_default=True,
              help="Seconds between two status lines of --plain.")  # fmt: skip
@click.option("--zenoh-port", type=click.IntRange(1024, 65000), help="Use this radio.zenoh_port instead of the file's.")
@click.option("--endpoint", "endpoints", multiple=True, metavar="TCP/HOST:PORT",
              help="Connect here instead of to the mission's agents; may be given several times.")  # fmt: skip
@click.option("--mavlink", multiple=True, metavar="URL",
              help="Hear the autopilots' own heartbeats too, at udpin://HOST:PORT or tcpout://HOST:PORT.")  # fmt: skip
@click.option("--record", type=click.Path(path_type=Path, dir_okay=False), help="Keep an MCAP recording in this file.")
@click.option("--replay", type=click.Path(path_type=Path), metavar="RUN", help="Show a run folder or .mcap file again.")
@click.option("--speed", type=click.FloatRange(0.1, 100.0), default=1.0, show_default=True, help="Pace of --replay.")
@click.option("--serve", "served", is_flag=True, help="Show the dashboard in a browser instead of on this terminal.")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address of --serve.")
@click.option("--port", type=click.IntRange(1, 65535), default=8000, show_default=True, help="Port of --serve.")
@click.option("--notice-file", type=click.Path(path_type=Path), help="Show this file's line until a vehicle is live.")
@click.option("--exit-when-done", is_flag=True, help="End when every vehicle has finished or is lost.")
@click.option("--stops-mission", is_flag=True, help="Ctrl-C asks to stop the whole run: exit code 130.")
def main(
    mission: Path | None,
    plain: bool,
    zenoh_port: int | None,
    replay: Path | None,
    speed: float,
    served: bool,
    host: str,
    port: int,
    interval: float,
    **rest: object,
) -> None:
    """Watch and command the fleet that flies MISSION (a mission file), or show a recorded run again."""
    if (mission is None) == (replay is None):
        raise click.UsageError("give either a MISSION file or --replay RUN")
    options = Options(interval_s=interval, **rest)  # type: ignore[arg-type]
    if served:
        _serve(sys.argv[1:], host, port)
        return
    in_browser = WEB_DRIVER in os.environ
    on_terminal = all(stream.isatty() for stream in (sys.stdin, sys.stdout, sys.stderr))
    plain = plain or not (on_terminal or in_browser)
    if not plain and not in_browser:
        _check_size()
    if replay is not None:
        _replay(replay, speed, plain, options)
        return
    assert mission is not None
    try:
        plan = load_mission(mission, partial(_with_port, port=zenoh_port))
    except MissionError as error:
        _refuse(str(error))
    if plain:
        _plain(plan, options)
    else:
        _dashboard(plan, options)


def _with_port(mission: Mission, port: int | None) -> Mission:
    if port is None:
        return mission
    return msgspec.structs.replace(mission, radio=msgspec.structs.replace(mission.radio, zenoh_port=port))


def _check_size() -> None:
    width, height = os.get_terminal_size(sys.stderr.fileno())
    if 0 < width < MIN_START_WIDTH or 0 < height < MIN_START_HEIGHT:
        _refuse(
            f"the terminal has {width}x{height} characters; enlarge it to 80x24 (at least "
            f"{MIN_START_WIDTH}x{MIN_START_HEIGHT}), or use --plain"
        )


def _station(plan: MissionPlan, name: str, options: Options) -> Station:
    from ground_station.mavlink_ears import EarsError, MavlinkEars
    from ground_station.station import Station

    recording, record = None, options.record
    if record is not None:
        from ground_station.recording import RecordingWriter

        try:
            recording = RecordingWriter(record)
        except OSError as error:
            _refuse(f"{record}: {error.strerror}; choose another file with --record")
    try:
        ears = MavlinkEars(options.mavlink) if options.mavlink else None
    except EarsError as error:
        _refuse(str(error))
    return Station(plan, name, secrets.randbits(32), time.monotonic(), recording=recording, ears=ears)


def _plain(plan: MissionPlan, options: Options) -> None:
    from ground_station.link import open_link, station_name
    from ground_station.plain import run_plain
    from vehicle_agent.link.session import LinkError

    _keep_to_ascii(options)
    name = station_name()
    station = _station(plan, name, options)
    try:
        run_plain(
            station,
            partial(open_link, plan, name, options.endpoints),
            interval_s=options.interval_s,
            notice_file=options.notice_file,
            exit_when_done=options.exit_when_done,
        )
    except LinkError as error:
        _refuse(str(error))
    except BrokenPipeError:
        _end_quietly()
    finally:
        station.close()


def _dashboard(plan: MissionPlan, options: Options) -> None:
    look = _look(options)
    from ground_station.app import DRAW_PERIOD_S, GroundStationApp, run_on_terminal
    from ground_station.link import open_link, station_name

    name = station_name()
    station = _station(plan, name, options)
    app = GroundStationApp(
        station,
        partial(open_link, plan, name, options.endpoints),
        look,
        notice_file=options.notice_file,
        exit_when_done=options.exit_when_done,
        stops_mission=options.stops_mission,
        draw_period_s=LOW_BANDWIDTH_PERIOD_S if options.low_bandwidth else DRAW_PERIOD_S,
        theme_name=options.theme,
    )
    try:
        run_on_terminal(app)
    finally:
        station.close()
    if app.refusal:
        _refuse(app.refusal)
    sys.exit(app.return_code or 0)


def _replay(run: Path, speed: float, plain: bool, options: Options) -> None:
    from ground_station.player import Player
    from ground_station.recording import Recording, RecordingError

    try:
        player = Player(Recording(run), speed)
    except RecordingError as error:
        _refuse(str(error))
    try:
        if plain:
            _replay_lines(player, options)
        else:
            look = _look(options)
            from ground_station.app import DRAW_PERIOD_S, GroundStationApp, run_on_terminal

            period_s = LOW_BANDWIDTH_PERIOD_S if options.low_bandwidth else DRAW_PERIOD_S
            app = GroundStationApp(player, None, look, draw_period_s=period_s, theme_name=options.theme)
            run_on_terminal(app)
            sys.exit(app.return_code or 0)
    finally:
        player.close()


def _replay_lines(player: Player, options: Options) -> None:
    from ground_station.plain import replay_lines

    _keep_to_ascii(options)
    try:
        for line in replay_lines(player, options.interval_s):
            print(line)
        sys.stdout.flush()
    except BrokenPipeError:
        _end_quietly()


def _serve(arguments: list[str], host: str, port: int) -> None:
    from ground_station.serve import ServeError, is_loopback, serve

    if not is_loopback(host):
        print(f"ground-station: whoever reaches {host}:{port} can command the fleet", file=sys.stderr)
    own = {"--host", "--port"}
    kept = [
        word
        for at, word in enumerate(arguments)
        if word != "--serve" and word.partition("=")[0] not in own and (at == 0 or arguments[at - 1] not in own)
    ]
    try:
        serve(kept, host, port, "ground station")
    except ServeError as error:
        _refuse(str(error))


def _look(options: Options) -> Look:
    """What the terminal can show; to be called before Textual is loaded, which reads the environment once."""
    from ground_station.views.ink import Look

    if options.low_bandwidth:
        os.environ["TEXTUAL_COLOR_SYSTEM"] = "standard"
        os.environ["TEXTUAL_ANIMATIONS"] = "none"
    encoding = (sys.stdout.encoding or "").lower().replace("-", "")
    capable = encoding == "utf8" or WEB_DRIVER in os.environ
    return Look(unicode=not options.ascii_only and capable, colour="NO_COLOR" not in os.environ)


def _keep_to_ascii(options: Options) -> None:
    if options.ascii_only and isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(encoding="ascii", errors="replace")


def _end_quietly() -> None:
    """Whoever read the lines has gone: a second complaint at interpreter exit is avoided by a harmless stdout."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _refuse(sentence: str) -> NoReturn:
    print(f"ground-station: {sentence}", file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    main()
