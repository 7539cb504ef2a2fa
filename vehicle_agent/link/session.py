"""A participant's link to its fleet over Zenoh: typed messages in and out, never blocking the one who calls."""

from __future__ import annotations

import logging
import re
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace

import zenoh
import zenoh.ext

from vehicle_agent.link.counters import LinkCounters
from vehicle_agent.link.pacing import BulkSender, TokenBucket
from vehicle_agent.link.profile import session_profile, zenoh_config
from vehicle_agent.link.receiving import Arrival, ReceiveQueue
from vehicle_agent.link.tls import TlsFiles
from vehicle_agent.wire.codec import Codec
from vehicle_agent.wire.keys import TOPIC_BY_NAME, Delivery, Topic, Urgency, alive_key, key, parse, topic_of
from vehicle_agent.wire.messages import NAME_PATTERN, AnyMessage

PACED_SHARE = 0.75
"""Share of a declared rate that is used: above it, heartbeats queue behind bulk whatever their priority."""
MISS_HEARTBEAT_S = 0.5
"""Period after which a subscriber learns that it missed a sender's last event."""

_PRIORITIES = {
    Urgency.HIGH: zenoh.Priority.INTERACTIVE_HIGH,
    Urgency.NORMAL: zenoh.Priority.DATA,
    Urgency.LOW: zenoh.Priority.DATA_LOW,
}
_log = logging.getLogger(__name__)


class LinkError(Exception):
    """A link that cannot be opened; its text is one sentence with the endpoint and the mend."""


class FleetLink:
    """One participant (vehicle, station, simulator or referee) of one mission.

    All methods are for one thread, the owner's; Zenoh's threads only enqueue.

    Example
    -------
    ::

        link = FleetLink.open("ridge", "station", connect=["tcp/127.0.0.1:7451"])
        link.subscribe("status")
        for message in link.poll():
            ...
        link.close()
    """

    def __init__(
        self,
        session: zenoh.Session,
        mission: str,
        participant: str,
        rate_bytes_s: float | None,
        clock: Callable[[], float],
    ) -> None:
        self.mission = mission
        self.participant = participant
        self._session = session
        self._codec = Codec()
        self._counts = LinkCounters()
        self._counts_lock = threading.Lock()
        self._arrivals = ReceiveQueue()
        self._alive_changes: deque[tuple[str, bool]] = deque()
        self._publishers: dict[str, zenoh.Publisher | zenoh.ext.AdvancedPublisher] = {}
        self._declared: list[object] = []
        self._bucket = TokenBucket(PACED_SHARE * rate_bytes_s, clock) if rate_bytes_s else None
        self._bulk: BulkSender | None = None

    @classmethod
    def open(
        cls,
        mission: str,
        participant: str,
        *,
        listen: Sequence[str] = (),
        connect: Sequence[str] = (),
        rate_bytes_s: float | None = None,
        clock: Callable[[], float] = time.monotonic,
        tls: TlsFiles | None = None,
    ) -> FleetLink:
        """Open a link; endpoints in `connect` that cannot be reached yet are tried in the background.

        Parameters
        ----------
        mission, participant
            Names as they stand in keys.
        listen, connect
            Zenoh endpoints, e.g. `tcp/127.0.0.1:7451`.
        rate_bytes_s
            Declared capacity; bulk is sent only while everything together stays below 75 % of it. None: unpaced.
        clock
            The seconds in which the rate counts; a vehicle's own where that runs faster than real time.
        tls
            Certificates for endpoints like `tls/127.0.0.1:7451`.

        Raises
        ------
        LinkError
            When an endpoint is malformed or cannot be listened on, or a certificate cannot be used.
        """
        for what, name in (("mission", mission), ("participant", participant)):
            if not re.match(NAME_PATTERN, name):
                raise LinkError(
                    f"{what} name '{name}' does not fit in a key; use lower-case letters, digits and dashes"
                )
        trouble = tls.trouble() if tls else None
        if trouble:
            raise LinkError(trouble)
        try:
            session = zenoh.open(zenoh_config(session_profile(listen, connect, tls.profile() if tls else None)))
        except zenoh.ZError as error:
            raise LinkError(_explain(str(error), listen, connect)) from None
        return cls(session, mission, participant, rate_bytes_s, clock)

    @property
    def counters(self) -> LinkCounters:
        """A snapshot of the counts so far."""
        with self._counts_lock:
            return replace(
                self._counts,
                overflowed=self._arrivals.overflowed,
                paced_out=self._bulk.paced_out if self._bulk else 0,
            )

    def connected_peers(self) -> int:
        """How many other sessions this one is connected to right now."""
        return len(self._session.info.peers_zid())

    def subscribe(self, topic_name: str, participant: str = "*") -> None:
        """Receive a topic of one participant, or of all others; never what this link itself says."""
        topic = TOPIC_BY_NAME[topic_name]
        expression = key(self.mission, participant, topic)
        expendable = topic.delivery is Delivery.LATEST

        def enqueue(sample: zenoh.Sample) -> None:
            self._arrivals.put(str(sample.key_expr), sample.payload.to_bytes(), expendable)

        if topic.delivery is Delivery.RECOVERED:
            subscriber: object = zenoh.ext.declare_advanced_subscriber(
                self._session,
                expression,
                enqueue,
                allowed_origin=zenoh.Locality.REMOTE,
                history=zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=topic.history),
                recovery=zenoh.ext.RecoveryConfig(periodic_queries=None, heartbeat=True),
            )
        else:
            subscriber = self._session.declare_subscriber(expression, enqueue, allowed_origin=zenoh.Locality.REMOTE)
        self._declared.append(subscriber)

    def poll(self) -> list[AnyMessage]:
        """Take the messages that arrived since the last poll, in order of arrival."""
        messages = []
        received_bytes = received = undecodable = 0
        for arrival in self._arrivals.take_all():
            message = self._decode(arrival)
            if message is None:
                undecodable += 1
                continue
            messages.append(message)
            received += 1
            if topic_of(message).over_radio:
                received_bytes += len(arrival.payload) + len(arrival.key_text)
        with self._counts_lock:
            self._counts.messages_received += received
            self._counts.bytes_received += received_bytes
            self._counts.undecodable += undecodable
        return messages

    def publish(self, message: AnyMessage, participant: str | None = None) -> None:
        """Say a message on its topic's key of `participant` (own by default). Never blocks, never raises.

        On topics that go over the radio the sender and the key's participant must be the same, or ValueError.
        """
        topic = topic_of(message)
        participant = participant or self.participant
        if topic.over_radio and message.sender != participant:
            raise ValueError(f"{topic.name} of {message.sender} cannot be said on a key of {participant}")
        key_text = key(self.mission, participant, topic)
        payload = self._codec.encode(message)
        if topic.delivery is Delivery.BULK:
            if self._bulk is None:
                self._bulk = BulkSender(self._put, self._bucket if topic.over_radio else None, self.participant)
            self._publisher(key_text, topic)
            self._bulk.put(key_text, payload)
            return
        if self._bucket is not None and topic.over_radio:
            self._bucket.charge(len(payload) + len(key_text))
        self._publisher(key_text, topic)
        self._put(key_text, payload)

    def declare_alive(self) -> None:
        """Show that this participant lives, until it closes, dies or is cut off."""
        token = self._session.liveliness().declare_token(alive_key(self.mission, self.participant))
        self._declared.append(token)

    def watch_alive(self) -> None:
        """Collect who lives and who dies for `poll_alive`."""

        def enqueue(sample: zenoh.Sample) -> None:
            names = parse(str(sample.key_expr))
            if names is not None:
                self._alive_changes.append((names[1], sample.kind == zenoh.SampleKind.PUT))

        subscriber = self._session.liveliness().declare_subscriber(alive_key(self.mission, "*"), enqueue, history=True)
        self._declared.append(subscriber)

    def poll_alive(self) -> list[tuple[str, bool]]:
        """Take the changes since the last poll: (participant, alive), in order."""
        changes = []
        while self._alive_changes:
            participant, alive = self._alive_changes.popleft()
            if participant != self.participant:
                changes.append((participant, alive))
        return changes

    def close(self, timeout_s: float = 3.0) -> None:
        """Say good-bye and close, within `timeout_s`; a session that hangs is left to die with the process."""
        deadline_s = time.monotonic() + timeout_s
        if self._bulk is not None:
            self._bulk.stop(timeout_s / 2)
        closer = threading.Thread(target=self._close_session, name=f"close-{self.participant}", daemon=True)
        closer.start()
        closer.join(max(0.0, deadline_s - time.monotonic()))

    def _close_session(self) -> None:
        try:
            self._session.close()  # type: ignore[no-untyped-call]
        except zenoh.ZError as error:
            _log.info("the link of %s did not close cleanly: %s", self.participant, error)

    def _publisher(self, key_text: str, topic: Topic) -> zenoh.Publisher | zenoh.ext.AdvancedPublisher | None:
        """Publisher of a key, declared at its first use; None when Zenoh refuses, which `_put` counts."""
        if key_text not in self._publishers:
            try:
                self._publishers[key_text] = self._declare(key_text, topic)
            except zenoh.ZError as error:
                _log.warning("cannot publish on %s: %s", key_text, error)
        return self._publishers.get(key_text)

    def _declare(self, key_text: str, topic: Topic) -> zenoh.Publisher | zenoh.ext.AdvancedPublisher:
        if topic.delivery is Delivery.RECOVERED:
            return zenoh.ext.declare_advanced_publisher(
                self._session,
                key_text,
                congestion_control=zenoh.CongestionControl.DROP,  # what is dropped is recovered
                priority=_PRIORITIES[topic.urgency],
                allowed_destination=zenoh.Locality.REMOTE,
                cache=zenoh.ext.CacheConfig(topic.history),
                sample_miss_detection=zenoh.ext.MissDetectionConfig(
                    heartbeat=None, sporadic_heartbeat=MISS_HEARTBEAT_S
                ),
                publisher_detection=True,
            )
        bulk = topic.delivery is Delivery.BULK
        return self._session.declare_publisher(
            key_text,
            congestion_control=zenoh.CongestionControl.BLOCK if bulk else zenoh.CongestionControl.DROP,
            priority=_PRIORITIES[topic.urgency],
            allowed_destination=zenoh.Locality.REMOTE,
        )

    def _put(self, key_text: str, payload: bytes) -> None:
        """Hand bytes to Zenoh and count them; on the owner's thread, or for bulk on the bulk sender's."""
        parts = parse(key_text)
        assert parts is not None
        size_bytes = len(payload) + len(key_text) if TOPIC_BY_NAME[parts[2]].over_radio else 0
        try:
            publisher = self._publishers.get(key_text)
            if publisher is not None:
                publisher.put(payload)
            sent = publisher is not None
        except zenoh.ZError as error:
            _log.debug("not sent on %s: %s", key_text, error)
            sent = False
        with self._counts_lock:
            if sent:
                self._counts.messages_sent += 1
                self._counts.bytes_sent += size_bytes
            else:
                self._counts.send_failures += 1

    def _decode(self, arrival: Arrival) -> AnyMessage | None:
        """The message of an arrival; None when the bytes are wrong or do not belong on their key."""
        parts = parse(arrival.key_text)
        message = self._codec.decode(arrival.payload)
        if message is None or parts is None:
            return None
        _, participant, topic_name = parts
        topic = topic_of(message)
        if topic.name != topic_name or (topic.over_radio and message.sender != participant):
            return None
        return message


def _explain(error: str, listen: Sequence[str], connect: Sequence[str]) -> str:
    """Turn Zenoh's refusal to open into a sentence with the endpoint and the mend."""
    known = [*listen, *connect]
    endpoint = next((known_endpoint for known_endpoint in known if known_endpoint in error), ", ".join(known))
    if "Address already in use" in error:
        return (
            f"{endpoint}: the port is in use; end the program that holds it, or choose another radio.zenoh_port in the "
            f"mission file (or --zenoh-port)"
        )
    if "Cannot assign requested address" in error or "failed to lookup address" in error:
        return f"{endpoint}: not an address of this machine; correct radio.endpoint_host in the mission file"
    if "Permission denied" in error:
        return f"{endpoint}: this user may not listen there; choose another radio.zenoh_port in the mission file"
    reason = error.split(" at /")[0].rstrip(". ")
    return f"{endpoint}: not a usable Zenoh endpoint ({reason}); write it like tcp/127.0.0.1:7451"
