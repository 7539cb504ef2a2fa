"""Works out what became of a run: joins the vehicles' maps, asks the referee's file, and judges."""

from __future__ import annotations

import math
import zipfile
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from missions.covered import covered_fraction, covers
from missions.depth_map import draw_depth_map, maps, write_depth_map
from missions.ending import Ending, MissionWatch, VehicleRecord
from missions.summary import Summary, VehicleSummary
from missions.yardstick import map_of_arrays, merged, share_seen, unseen_words
from vehicle_agent.adapters.file_journal import FileJournal, JournalError, JournalHeader
from vehicle_agent.behaviour.map_exchange import MapExchange
from vehicle_agent.behaviour.outfit import make_shared_map
from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.landmark_atlas import LandmarkAtlas
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.team_map import TeamMap
from vehicle_agent.mission.load import MissionPlan

AIM_FRACTION = 0.99
"""Share of the reachable surface that a successful run has observed."""
HOME_WITHIN_M = 10.0
"""Horizontal distance from its start within which a landed vehicle counts as returned."""


class RefereeResult(msgspec.Struct, frozen=True):
    """What is read of the simulator's `sim_result.json`; its other keys are for people."""

    min_separation_m: float | None = None
    fence_breaches: int | None = None
    crashes: int | None = None


@dataclass(frozen=True, slots=True)
class RunFacts:
    """What the supervisor knows of a run that the files do not tell.

    Attributes
    ----------
    ending, ending_text
        Why it was over.
    wall_s, first_airborne_wall_s
        Wall time of the run and until the first vehicle was armed.
    peak_memory_bytes
        Of all processes together, proportional set size.
    warnings
        Sentences collected on the way.
    """

    ending: Ending
    ending_text: str
    wall_s: float
    first_airborne_wall_s: float | None
    peak_memory_bytes: int
    warnings: tuple[str, ...]


def load_map(path: Path, plan: MissionPlan) -> TeamMap | None:
    """Read one vehicle's `map.npz`; None when it is missing, torn or of another mission's grid."""
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return map_of_arrays(plan, arrays)
    except (OSError, ValueError, KeyError, IndexError, zipfile.BadZipFile):
        return None


def replay_journal(plan: MissionPlan, index: int, run_dir: Path) -> TeamMap | None:
    """What one vehicle had journalled of its own observations; None when its journal is missing or not its own."""
    name = plan.vehicle_names[index]
    path = run_dir / name / "journal.bin"
    if not path.is_file():
        return None
    try:
        journal = FileJournal.open(path, JournalHeader.of(plan, name))
    except JournalError:
        return None
    try:
        return MapExchange(make_shared_map(plan, index), plan.vehicle_names, index, 0, journal.records()).team_map
    finally:
        journal.close()


def join_maps(plan: MissionPlan, run_dir: Path) -> TeamMap:
    """Merge what every vehicle of a run left behind into one map: its map, and the journal of one that was killed."""
    found = [make_shared_map(plan, 0).team_map]
    for index, name in enumerate(plan.vehicle_names):
        left = (load_map(run_dir / name / "map.npz", plan), replay_journal(plan, index, run_dir))
        found += [one for one in left if one is not None]
    return merged(found)


def read_referee(run_dir: Path) -> RefereeResult | None:
    """Read the simulator's verdict; None when there is none."""
    try:
        return msgspec.json.decode((run_dir / "sim_result.json").read_bytes(), type=RefereeResult)
    except (OSError, msgspec.DecodeError):
        return None


def summarise(
    plan: MissionPlan,
    run_dir: Path,
    watch: MissionWatch,
    facts: RunFacts,
    reachable: BoolArray | None,
    elevation_m: FloatArray | None = None,
    solid: BoolArray | None = None,
) -> Summary:
    """Judge a run.

    Parameters
    ----------
    reachable : bool, the surface that can be seen at all, as of `missions.yardstick.observable`; None when nobody
        knows the true terrain.
    elevation_m : (columns, rows) float64, the true surface, ENU z; None likewise: the team's map stands for it.
    solid : (columns, rows, layers) bool, what is solid of a true town.
    """
    joined = join_maps(plan, run_dir)
    covered = None
    if covers(plan):
        places = {name: r.worked_at_m for name, r in watch.vehicles.items() if r.worked_at_m is not None}
        found = joined.elevation_m if isinstance(joined, ElevationMap) else joined.observed
        true = elevation_m if solid is None else solid
        covered = covered_fraction(plan, found if true is None else true, places)
    map_error_m = None
    if isinstance(joined, LandmarkAtlas) and (drawn := draw_depth_map(plan, joined, elevation_m)) is not None:
        write_depth_map(plan, drawn, run_dir)
        map_error_m = drawn.rms_error_m
    referee = read_referee(run_dir)
    within = _unknown_surface(plan, joined) if reachable is None else reachable
    observed_fraction = share_seen(joined.observed, within)
    seen_cells = max(1, int(np.count_nonzero(joined.observed)))
    vehicles = [
        _vehicle_summary(plan, index, record, joined.first_observer_share(index) / seen_cells)
        for index, record in enumerate(watch.vehicles.values())
    ]
    return Summary(
        mission=plan.mission.name,
        title=plan.mission.title,
        seed=plan.mission.seed,
        speedup=plan.mission.simulation.speedup,
        verdict=verdict(facts, vehicles, 1.0 if covers(plan) or maps(plan) else observed_fraction),
        ending=facts.ending.value,
        observed_fraction=observed_fraction,
        not_seen="" if maps(plan) else unseen_words(plan, joined.observed, within),
        covered_fraction=covered,
        map_error_m=map_error_m,
        truth_known=reachable is not None,
        elapsed_s=watch.elapsed_s,
        wall_s=facts.wall_s,
        first_airborne_wall_s=facts.first_airborne_wall_s,
        vehicles=vehicles,
        min_separation_m=referee.min_separation_m if referee else None,
        fence_breaches=referee.fence_breaches if referee else None,
        crashes=referee.crashes if referee else None,
        peak_memory_bytes=facts.peak_memory_bytes,
        warnings=list(facts.warnings),
    )


def _unknown_surface(plan: MissionPlan, joined: TeamMap) -> BoolArray:
    """What counts where nobody knows the truth: all cells of the area; of a town what is known of it."""
    return plan.area_cells if plan.voxel_grid is None else joined.observed


def verdict(facts: RunFacts, vehicles: list[VehicleSummary], observed_fraction: float) -> str | None:
    """None when the run reached its aim, else the first reason why not, as a sentence."""
    if facts.ending is not Ending.COMPLETE:
        return facts.ending_text
    for vehicle in vehicles:
        if not vehicle.home_and_disarmed and not (vehicle.agent_lost and vehicle.disarmed):
            return f"{vehicle.name} is not home and disarmed"
    if observed_fraction < AIM_FRACTION:
        return f"{100 * observed_fraction:.2f} % observed, less than {100 * AIM_FRACTION:.0f} %"
    return None


def _vehicle_summary(plan: MissionPlan, index: int, record: VehicleRecord, first_seen_share: float) -> VehicleSummary:
    vehicle, status = plan.mission.vehicles[index], record.status
    position = record.position_m
    near_home = position is not None and math.dist(position[:2], vehicle.start_enu_m[:2]) <= HOME_WITHIN_M
    span_s = 0.0
    if status is not None and record.first_stamp_ms is not None:
        span_s = (status.stamp_ms - record.first_stamp_ms) / 1000.0
    bytes_sent = status.bytes_sent if status else 0
    return VehicleSummary(
        name=vehicle.name,
        stage=status.stage.name.lower().replace("_", "-") if status else "never-heard",
        agent_lost=record.agent_ended,
        disarmed=record.disarmed,
        home_and_disarmed=(near_home and record.disarmed) if position is not None else None,
        flown_m=record.flown_m,
        first_seen_share=first_seen_share,
        bytes_sent=bytes_sent,
        bytes_per_s=bytes_sent / span_s if span_s > 0 else 0.0,
        messages_dropped=status.messages_dropped if status else 0,
    )
