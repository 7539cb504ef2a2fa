"""What became of a mission, as `summary.json` keeps it."""

from __future__ import annotations

from pathlib import Path

import msgspec

from vehicle_agent.mission.load import MissionError

SUMMARY_FILE = "summary.json"
FORMAT = 1


class VehicleSummary(msgspec.Struct, frozen=True, kw_only=True):
    """One vehicle.

    Attributes
    ----------
    stage
        Last stage its agent reported, in words.
    agent_lost
        Its agent ended before the mission did.
    disarmed
        Known to be disarmed at the end.
    home_and_disarmed
        Disarmed within `HOME_WITHIN_M` of its start; None when nothing was heard of it.
    flown_m
        Length of its track.
    first_seen_share
        Share of the observed surface that it saw first, ties shared (Renzaglia eq. 5).
    bytes_sent, bytes_per_s
        Over the radio, in total and per second of vehicle time.
    messages_dropped
        By its own link.
    """

    name: str
    stage: str
    agent_lost: bool
    disarmed: bool
    home_and_disarmed: bool | None
    flown_m: float
    first_seen_share: float
    bytes_sent: int
    bytes_per_s: float
    messages_dropped: int


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """A whole run.

    Attributes
    ----------
    format
        Version of this file.
    verdict
        None when the mission reached its aim, else a sentence that tells why not.
    ending
        Why it was over: a word for programs.
    observed_fraction
        Share of the reachable surface observed, on all maps together.
    covered_fraction
        Share of the area in sight at once from where the vehicles were last at work; None but for a task `cover`.
    map_error_m
        Root mean square error of the depth map; None but for a task `map` over a simulated surface.
    truth_known
        The reachable surface was worked out from the simulator's terrain; else it is the whole area.
    not_seen
        What of the area was not observed, in words; empty when all of it was.
    elapsed_s
        Vehicle time from the first take-off until the last vehicle was down.
    wall_s, first_airborne_wall_s
        Wall time of the whole run, and until the first vehicle was armed.
    min_separation_m, fence_breaches, crashes
        By the simulator's referee; None without it.
    peak_memory_bytes
        Proportional set size of all processes together, largest sample.
    warnings
        Sentences about what went wrong on the way.
    """

    format: int = FORMAT
    mission: str
    title: str
    seed: int
    speedup: float
    verdict: str | None
    ending: str
    observed_fraction: float
    truth_known: bool
    elapsed_s: float
    wall_s: float
    first_airborne_wall_s: float | None
    vehicles: list[VehicleSummary]
    not_seen: str = ""
    covered_fraction: float | None = None
    map_error_m: float | None = None
    min_separation_m: float | None = None
    fence_breaches: int | None = None
    crashes: int | None = None
    peak_memory_bytes: int = 0
    warnings: list[str] = []


def write_summary(summary: Summary, run_dir: Path) -> None:
    text = msgspec.json.format(msgspec.json.encode(summary), indent=2)
    (run_dir / SUMMARY_FILE).write_bytes(text + b"\n")


def read_summary(run_dir: Path) -> Summary:
    """Read a run's summary; raises MissionError with a sentence when there is none that can be read."""
    path = run_dir / SUMMARY_FILE
    try:
        return msgspec.json.decode(path.read_bytes(), type=Summary)
    except FileNotFoundError:
        raise MissionError(
            f"{path}: no such file; give the folder of a run that has ended, e.g. runs/<time>-<name>"
        ) from None
    except OSError as error:
        raise MissionError(f"{path}: cannot be read ({error.strerror}); check the path and its permissions") from None
    except msgspec.DecodeError as error:
        raise MissionError(
            f"{path}: is not a run's summary ({error}); give the folder of a run that has ended"
        ) from None


def summary_text(summary: Summary, run_dir: Path) -> str:
    """The summary for people, about fifteen lines of at most 100 characters."""
    surface = "reachable surface" if summary.truth_known else "area"
    verdict = "reached its aim" if summary.verdict is None else f"did not reach its aim: {summary.verdict}"
    lines = [
        f"{summary.mission}: {verdict}",
        f"  observed   {100 * summary.observed_fraction:.2f} % of the {surface}",
        f"  time       {_minutes(summary.elapsed_s)} of vehicle time, {_minutes(summary.wall_s)} of yours"
        f" (speed-up {summary.speedup:g}, seed {summary.seed})",
    ]
    if summary.not_seen:
        lines.insert(2, f"  not seen   {summary.not_seen}")
    if summary.covered_fraction is not None:
        covered = f"{100 * summary.covered_fraction:.2f} % of the area at once, from where the team stayed"
        lines.insert(1, f"  covered    {covered}")
    if summary.map_error_m is not None:
        lines.insert(
            2, f"  depth map  {summary.map_error_m:.2f} m root mean square error, in depth_map.csv, .asc and .npz"
        )
    if summary.first_airborne_wall_s is not None:
        lines.append(f"  airborne   first vehicle after {summary.first_airborne_wall_s:.1f} s")
    if summary.fence_breaches is not None:
        apart = "-" if summary.min_separation_m is None else f"{summary.min_separation_m:.1f}"
        lines.append(
            f"  safety     closest two vehicles in the air {apart} m, "
            f"{summary.fence_breaches} fence breaches, {summary.crashes} crashes"
        )
    lines.append(f"  memory     {summary.peak_memory_bytes / 2**20:.0f} MiB at most, all processes together (PSS)")
    width = max(7, *(len(vehicle.name) for vehicle in summary.vehicles))
    lines.append(
        f"  {'vehicle':<{width}}  {'stage':<10} {'home':<5} {'flown':>8} {'saw first':>9} "
        f"{'sent':>9} {'per s':>8} {'dropped':>7}"
    )
    lines += [_vehicle_line(vehicle, width) for vehicle in summary.vehicles]
    lines += [f"  note: {warning}" for warning in summary.warnings]
    lines.append(f"  kept in    {run_dir}")
    return "\n".join(lines)


def _vehicle_line(vehicle: VehicleSummary, width: int) -> str:
    home = {True: "yes", False: "NO", None: "?"}[vehicle.home_and_disarmed]
    stage = "lost" if vehicle.agent_lost else vehicle.stage
    return (
        f"  {vehicle.name:<{width}}  {stage:<10} {home:<5} {vehicle.flown_m / 1000:>5.1f} km "
        f"{100 * vehicle.first_seen_share:>7.1f} % {vehicle.bytes_sent / 1000:>6.0f} kB "
        f"{vehicle.bytes_per_s:>4.0f} B/s {vehicle.messages_dropped:>7}"
    )


def _minutes(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds // 60:.0f} min {seconds % 60:.0f} s"
