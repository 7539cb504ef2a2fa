"""How much vehicles of a mission say at once, and how often they tell how they are."""

from __future__ import annotations

from vehicle_agent.mission.plan import MissionPlan
from vehicle_agent.mission.tasks import MapTask

OPEN_WATER_PACKET_BYTES, OPEN_WATER_PERIOD_S = 1_000, 2.0
"""Of a mapping team's radio that is no modem."""
PACKETS_PER_STATUS = 3
"""Of a mapping vehicle's packets each so-many-th tells how it is, the others of landmarks."""
STATUS_PERIOD_S = 1.0


def packet_of(plan: MissionPlan) -> tuple[int, float]:
    """Bytes of a mapping vehicle's packet, and seconds between two."""
    radio = plan.mission.radio
    if radio.packet_bytes is None:
        return OPEN_WATER_PACKET_BYTES, OPEN_WATER_PERIOD_S
    return radio.packet_bytes, radio.packet_period_s


def status_period_s(plan: MissionPlan) -> float:
    """Vehicle time between two statuses of one vehicle."""
    if not isinstance(plan.mission.task, MapTask):
        return STATUS_PERIOD_S
    return PACKETS_PER_STATUS * packet_of(plan)[1]
