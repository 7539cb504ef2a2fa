"""The team's radio: the `Team` port over a fleet link."""

from __future__ import annotations

from vehicle_agent.link.session import FleetLink
from vehicle_agent.wire.messages import AnyMessage

HEARD_TOPICS = ("status", "map", "claim", "command", "digest", "repair", "landmarks", "landmark-digest")
"""What an agent listens to; events and results are for stations, and a vehicle's radio is spared them."""


class ZenohTeam:
    """Hears its teammates and the stations, says whatever its agent says."""

    def __init__(self, link: FleetLink) -> None:
        self._link = link
        for topic_name in HEARD_TOPICS:
            link.subscribe(topic_name)
        link.declare_alive()

    def poll(self) -> list[AnyMessage]:
        return self._link.poll()

    def publish(self, message: AnyMessage) -> None:
        self._link.publish(message)
