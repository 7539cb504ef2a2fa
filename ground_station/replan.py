"""Re-planning: two pictures in, a proposal of commands out. Pure; who sends it, and when, is not decided here.

Agents redistribute by themselves when a teammate falls silent: all goals of a lost vehicle are free after
`safety.teammate_silence_s`. The policy does what a station knows sooner or alone: it releases a lost vehicle's goals at
once, gives a newcomer the orders that stand, and shares the rest of the area out for planners that do not do so.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ground_station.payload import Payload, polygon
from ground_station.picture import FleetState
from ground_station.prediction import Prediction, predict, works
from ground_station.vehicle_picture import Condition, VehiclePicture
from vehicle_agent.wire.messages import Orders, Stage, Verb

SHARING_PLANNERS = frozenset({"tours", "lanes", "claims"})
"""Planners that share unseen ground out among the living by themselves: a sector would only bind them."""
LLOYD_ROUNDS = 12
MIN_SHARED_CELLS = 20

Points = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Step:
    """One command of a proposal."""

    verb: Verb
    targets: tuple[str, ...]
    payload: Payload


@dataclass(frozen=True, slots=True)
class Proposal:
    """What the policy would do, and what it expects of it.

    Attributes
    ----------
    cause
        What happened, in words.
    steps
        In the order in which they are sent.
    before, after
        Expected time to finish without what happened, and with the proposal; None when unknown.
    """

    cause: str
    steps: tuple[Step, ...]
    before: Prediction | None = None
    after: Prediction | None = None


@dataclass(frozen=True, slots=True)
class ReplanPolicy:
    """Watches a fleet from picture to picture.

    Attributes
    ----------
    share_out
        Give every vehicle a sector of its own when the team changes; None: only for planners that do not share.
    """

    share_out: bool | None = field(default=None)

    def propose(self, earlier: FleetState, now: FleetState) -> Proposal | None:
        """What to do about what changed between two pictures; None when nothing calls for it."""
        lost, joined, early = _changes(earlier, now)
        if not (lost or joined or early):
            return None
        workers = [vehicle.name for vehicle in now.vehicles if works(vehicle)]
        steps = [Step(Verb.RELEASE, tuple(workers), Payload(subject=name)) for name in lost if workers]
        for name in joined:
            steps += standing_orders_for(now, name)
        if self._shares(now) and workers:
            steps += sectors(now, workers)
        if not steps:  # the agents do all that is to be done
            return None
        causes = [f"{name} is lost" for name in lost]
        causes += [f"{name} joined" for name in joined] + [f"{name} finished early" for name in early]
        before = predict(earlier, without=joined)
        return Proposal(", ".join(causes), tuple(steps), before, predict(now, joined=joined))

    def share(self, now: FleetState) -> Proposal | None:
        """Share the rest of the area out among those that work, at the operator's wish."""
        workers = [vehicle.name for vehicle in now.vehicles if works(vehicle)]
        steps = tuple(sectors(now, workers))
        expected = predict(now)
        return Proposal("the operator wants the rest shared out", steps, expected, expected) if steps else None

    def _shares(self, now: FleetState) -> bool:
        if self.share_out is not None:
            return self.share_out
        return now.plan.mission.task.planner not in SHARING_PLANNERS


def _changes(earlier: FleetState, now: FleetState) -> tuple[list[str], list[str], list[str]]:
    """Names of those that were lost at work, that joined, and that stopped while there is work left."""
    lost, joined, early = [], [], []
    goal = now.plan.mission.stop.observed_fraction
    for was, vehicle in zip(earlier.vehicles, now.vehicles, strict=True):
        if works(was) and vehicle.condition is Condition.LOST:
            lost.append(vehicle.name)
        elif was.condition is Condition.LOST and works(vehicle):
            joined.append(vehicle.name)
        elif works(was) and _has_turned_home(vehicle) and now.coverage < 0.98 * goal:
            early.append(vehicle.name)
    return lost, joined, early


def _has_turned_home(vehicle: VehiclePicture) -> bool:
    leaving = (Stage.RETURNING, Stage.LANDING, Stage.DONE)
    return vehicle.status is not None and vehicle.status.stage in leaving and vehicle.condition is Condition.LIVE


def standing_orders_for(state: FleetState, name: str) -> list[Step]:
    """The orders that stand at others and not at this vehicle, so that nothing is ordered twice."""
    own = next((vehicle.orders for vehicle in state.vehicles if vehicle.name == name), None)
    has = own or Orders(sender=name, boot_id=0, sequence=0, stamp_ms=0)
    kept = {zone.number: zone.polygon_cm for zone in has.no_fly}
    steps = [
        Step(Verb.NO_FLY, (name,), Payload(polygon_cm=corners, number=number))
        for number, corners in sorted(state.zones.items())
        if kept.get(number) != corners
    ]
    if state.area_cm and has.area_cm != state.area_cm:
        steps.append(Step(Verb.AREA, (name,), Payload(polygon_cm=state.area_cm)))
    return steps


def sectors(state: FleetState, names: list[str]) -> list[Step]:
    """A sector of the unseen ground for each vehicle: near to it, and about as large as the others'."""
    placed = [(one.name, one.position_enu_m) for one in state.vehicles if one.name in names and one.position_enu_m]
    unseen = state.team_map.area & ~state.team_map.elevation.observed
    points = state.plan.grid.centres_of(np.flatnonzero(unseen.ravel()))
    if len(placed) < 2 or len(points) < MIN_SHARED_CELLS * len(placed):
        return []
    owners = _balanced_owners(points, np.array([position[:2] for _, position in placed]))
    steps = []
    for at, (name, _) in enumerate(placed):
        hull = convex_hull(points[owners == at])
        if len(hull) >= 3:
            steps.append(Step(Verb.SECTOR, (name,), polygon([(float(e), float(n)) for e, n in hull])))
    return steps


def _balanced_owners(points: Points, seeds: Points) -> npt.NDArray[np.int64]:
    """Lloyd's iteration with weights that grow where a share is too large: (P, 2), (V, 2) -> (P,) owner of each."""
    centres = seeds.astype(np.float64).copy()
    weights = np.zeros(len(centres))
    fair = len(points) / len(centres)
    extent_m = float(np.ptp(points, axis=0).max()) or 1.0
    owners = np.zeros(len(points), dtype=np.int64)
    for _ in range(LLOYD_ROUNDS):
        distances = np.hypot(points[:, None, 0] - centres[None, :, 0], points[:, None, 1] - centres[None, :, 1])
        owners = np.argmin(distances + weights[None, :], axis=1)
        sizes = np.bincount(owners, minlength=len(centres))
        weights += 0.25 * extent_m / len(centres) * (sizes - fair) / fair
        for at in np.flatnonzero(sizes):
            centres[at] = points[owners == at].mean(axis=0)
    return owners


def convex_hull(points: Points) -> Points:
    """Corners of the smallest convex polygon around points, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted({(float(e), float(n)) for e, n in points})

    def half(sequence: list[tuple[float, float]]) -> list[tuple[float, float]]:
        chain: list[tuple[float, float]] = []
        for e, n in sequence:
            while len(chain) > 1:
                (ae, an), (be, bn) = chain[-2], chain[-1]
                if (be - ae) * (n - an) - (bn - an) * (e - ae) > 0:
                    break
                chain.pop()
            chain.append((e, n))
        return chain

    if len(ordered) < 3:
        return np.array(ordered).reshape(-1, 2)
    return np.array(half(ordered)[:-1] + half(ordered[::-1])[:-1])
