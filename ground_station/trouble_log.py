"""Findings over time: which troubles begin, last and end, and which of them the operator has seen or muted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ground_station.conditions import Kind, Trouble, findings, moment_of
from ground_station.vehicle_picture import VehiclePicture
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.messages import Severity

LOGGED_ELSEWHERE = (Kind.AGENT_DEAD, Kind.OUT_OF_REACH, Kind.SUSPECT, Kind.PILOT, Kind.REFUSED)
"""Kinds of which the log tells already: by the station's own loss entries or by the vehicle's own events."""


class TroubleLog:
    """The troubles of one batch of inputs in the making."""

    def __init__(self, troubles: tuple[Trouble, ...], muted: frozenset[tuple[str, Kind]]) -> None:
        self.troubles = troubles
        self.muted = muted

    def acknowledge(self, vehicle: str, kind: str) -> None:
        self.troubles = tuple(
            replace(one, acknowledged=True) if (one.vehicle, one.kind.name) == (vehicle, kind) else one
            for one in self.troubles
        )

    def mute(self, vehicle: str, kind: str, muted: bool) -> None:
        pair = (vehicle, Kind[kind])
        self.muted = self.muted | {pair} if muted else self.muted - {pair}

    def look(
        self, vehicles: tuple[VehiclePicture, ...], plan: MissionPlan, now_s: float, pace: float
    ) -> Iterator[tuple[str, Severity, str, str]]:
        """Judge every vehicle anew; yields (vehicle, severity, code, text) of what is worth a line in the log."""
        known = {(one.vehicle, one.kind): one for one in self.troubles}
        moment = moment_of(vehicles, now_s, pace)
        fresh: dict[tuple[str, Kind], Trouble] = {}
        for vehicle in vehicles:
            for found in findings(vehicle, plan, moment):
                pair = (vehicle.name, found.kind)
                last = known.get(pair)
                worse = last is not None and found.severity < last.severity
                fresh[pair] = Trouble(
                    vehicle.name,
                    found.kind,
                    found.severity,
                    found.text,
                    now_s if last is None else last.since_s,
                    last is not None and last.acknowledged and not worse,
                )
                if (last is None or worse) and self._is_news(pair):
                    yield (vehicle.name, found.severity, _code(found.kind), f"{found.kind.value}: {found.text}")
        for pair in known:
            if pair not in fresh and self._is_news(pair):
                yield (pair[0], Severity.NOTICE, f"{_code(pair[1])}-over", f"no longer {pair[1].value}")
        self.troubles = tuple(sorted(fresh.values(), key=lambda one: (one.severity, one.since_s, one.vehicle)))

    def _is_news(self, pair: tuple[str, Kind]) -> bool:
        return pair not in self.muted and pair[1] not in LOGGED_ELSEWHERE


def _code(kind: Kind) -> str:
    return kind.name.lower().replace("_", "-")
