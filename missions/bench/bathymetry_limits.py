"""Compares the usual practice on two kinds of sea floor with what no survey can better (`bathymetry_foreknown`)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from missions.bench.bathymetry import FLEET, FLOORS, INFORMED, SAMPLES, Case
from missions.bench.bathymetry_foreknown import Error, Foreknown, anywhere, descend, map_error, sailed
from missions.bench.bathymetry_run import MORE_SAMPLES, survey_by_fleet, survey_by_lines
from missions.bench.pool import measure_all
from missions.bench.results import Row, save_rows
from missions.terrain.sea_floor import FloorName
from vehicle_agent.domain.frames import FloatArray

ROUNDS = 150
"""Of a descent."""


@dataclass(frozen=True, slots=True)
class Limit:
    """What one method reached on one floor.

    Attributes
    ----------
    lines, more_lines
        The lawnmower's L2 error on this floor, at equal samples and at 7.5 times as many, from `missions bench
        bathymetry`.
    """

    floor: FloorName
    seed: int
    method: str
    l2_error: float
    lines: float
    more_lines: float


def measure(case: Case, rounds: int = ROUNDS) -> list[Limit]:
    """Look for the best tracks on one floor, from the lawnmower's and from those of who knows how rough it is."""
    known = Foreknown(case.floor, case.seed)
    lines = survey_by_lines(case.floor, case.seed, SAMPLES)
    more = survey_by_lines(case.floor, case.seed, round(MORE_SAMPLES * SAMPLES))
    informed = survey_by_fleet(case.floor, case.seed, INFORMED, informed=True)
    fleet = survey_by_fleet(case.floor, case.seed, FLEET)
    starts = (lines.places_en_m, informed.places_en_m)

    reached = {
        "fleet": fleet.l2_error,
        "informed": informed.l2_error,
        "lines, best map": map_error(known.expected, lines.places_en_m),
        "best tracks": _least(known.expected, [descend(known, known.expected, s, sailed, rounds, 1) for s in starts]),
        "anywhere": _least(known.expected, [descend(known, known.expected, starts[1], anywhere, rounds, 2)]),
        "true floor": _least(known.happened, [descend(known, known.happened, starts[1], sailed, rounds, 3)]),
    }
    return [
        Limit(case.floor, case.seed, method, error, lines.l2_error, more.l2_error) for method, error in reached.items()
    ]


def rows_of(limits: list[Limit]) -> list[Row]:
    """A row per floor and method, with its error over the lawnmower's, paired."""
    rows: list[Row] = []
    for floor in FLOORS:
        for method in dict.fromkeys(limit.method for limit in limits):
            alike = [limit for limit in limits if (limit.floor, limit.method) == (floor, method)]
            if not alike:
                continue
            errors = np.array([limit.l2_error for limit in alike])
            rows.append(
                {
                    "map": floor,
                    "method": method,
                    "seeds": len(alike),
                    "l2_error": round(float(errors.mean()), 3),
                    "l2_error_sd": round(float(errors.std()), 3),
                    "over_lines": round(float(np.mean([limit.l2_error / limit.lines for limit in alike])), 3),
                    "over_more_lines": round(float(np.mean([limit.l2_error / limit.more_lines for limit in alike])), 3),
                }
            )
    return rows


def table(rows: list[Row]) -> str:
    """The rows for people."""
    lines = [f"{'map':<6} {'method':<16} {'seeds':>5} {'L2 error':>16} {'/lawnmower':>11} {'/7.5 times':>11}"]
    lines += [
        f"{row['map']:<6} {row['method']:<16} {row['seeds']:>5} {row['l2_error']:>8.2f} sd {row['l2_error_sd']:>4.2f} "
        f"{row['over_lines']:>11.2f} {row['over_more_lines']:>11.2f}"
        for row in rows
    ]
    return "\n".join(lines)


def bench_limits(seeds: int, seed: int, json_file: Path | None) -> int:
    """Measure, print a table, write what was asked for; the exit code: 130 when Ctrl-C came before the end."""
    cases = [Case(floor, seed + number) for number in range(seeds) for floor in FLOORS]
    results, interrupted = measure_all(cases, measure, "limits")
    rows = rows_of([limit for limits in results for limit in limits])
    print(table(rows))
    if json_file is not None:
        save_rows(json_file, "bathymetry-limits", seed, rows)
    return 130 if interrupted else 0


def _least(error: Error, tracks: list[FloatArray]) -> float:
    return min(map_error(error, track) for track in tracks)
