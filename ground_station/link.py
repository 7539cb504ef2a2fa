"""The station on the link: what arrives becomes inputs of the reducer, and what the station says gets its number."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Protocol

from ground_station.inputs import AliveChanged, FleetInput, Heard, LinkCounted
from ground_station.payload import NOTHING, Payload
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.messages import AnyMessage, Command, Digest, StreamHeld, Verb

LISTENED_TOPICS = ("status", "map", "repair", "digest", "claim", "landmarks", "event", "result", "orders")


class Counts(Protocol):
    """The totals of a link that the station shows."""

    undecodable: int
    overflowed: int


class Link(Protocol):
    """What a station needs of `vehicle_agent.link.session.FleetLink`; every method is quick and none draws."""

    def poll(self) -> list[AnyMessage]: ...

    def poll_alive(self) -> list[tuple[str, bool]]: ...

    def publish(self, message: AnyMessage) -> None: ...

    @property
    def counters(self) -> Counts: ...

    def close(self) -> None: ...


def station_name() -> str:
    """A name of its own for every station, e.g. `station-3fa2`."""
    return f"station-{secrets.token_hex(2)}"


class StationLink:
    """Numbers and stamps what one station says.

    Attributes
    ----------
    station, boot_id
        Who speaks.
    """

    def __init__(self, link: Link, station: str, boot_id: int) -> None:
        self.station = station
        self.boot_id = boot_id
        self._link = link
        self._sequence = 0
        self._commands = 0

    def poll(self, now_s: float) -> list[FleetInput]:
        """What came in since the last poll, in order, as of station time `now_s`."""
        inputs: list[FleetInput] = [Heard(message, now_s) for message in self._link.poll()]
        inputs += [AliveChanged(name, alive, now_s) for name, alive in self._link.poll_alive()]
        counters = self._link.counters
        inputs.append(LinkCounted(counters.undecodable, counters.overflowed))
        return inputs

    def send_command(self, verb: Verb, targets: Sequence[str], stamp_ms: int, payload: Payload = NOTHING) -> Command:
        """Send an order; its results come in by `poll`."""
        command = Command(
            sender=self.station,
            boot_id=self.boot_id,
            sequence=self._next_sequence(),
            stamp_ms=stamp_ms,
            command_id=self._commands,
            verb=verb,
            targets=tuple(targets),
            point_cm=payload.point_cm,
            polygon_cm=payload.polygon_cm,
            number=payload.number,
            subject=payload.subject,
        )
        self._commands += 1
        self._link.publish(command)
        return command

    def send_digest(self, streams: tuple[StreamHeld, ...], stamp_ms: int) -> None:
        """Tell what this station's map holds, so that agents send what it lacks."""
        self._link.publish(
            Digest(
                sender=self.station,
                boot_id=self.boot_id,
                sequence=self._next_sequence(),
                stamp_ms=stamp_ms,
                streams=streams,
            )
        )

    def close(self) -> None:
        self._link.close()

    def _next_sequence(self) -> int:
        self._sequence += 1
        return self._sequence - 1


def open_link(plan: MissionPlan, station: str, endpoints: Sequence[str] = ()) -> Link:
    """Connect to every agent of a mission and listen; agents that cannot be reached yet are tried again.

    Parameters
    ----------
    endpoints
        Where to connect instead, e.g. `tcp/10.0.0.2:7447`.

    Raises `vehicle_agent.link.session.LinkError`, one sentence; also when a certificate is refused at either end.
    """
    from vehicle_agent.link.session import FleetLink, LinkError  # keeps Zenoh away from the first frame
    from vehicle_agent.link.tls import TlsFiles, refusal

    connect = list(endpoints) or [plan.agent_endpoint(index) for index in range(len(plan.vehicle_names))]
    tls = TlsFiles.of(plan.tls_paths(station))
    link = FleetLink.open(plan.mission.name, station, connect=connect, tls=tls)
    if tls is not None:
        with ThreadPoolExecutor(max_workers=len(connect)) as handshakes:
            refused = next(filter(None, handshakes.map(partial(refusal, files=tls), connect)), None)
        if refused is not None:
            link.close()
            raise LinkError(refused)
    link.watch_alive()
    for topic in LISTENED_TOPICS:
        link.subscribe(topic)
    return link
