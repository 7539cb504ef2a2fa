"""Says on Zenoh what each vehicle's sensor sees, and to referees where the bodies truly are."""

from __future__ import annotations

from typing import Protocol

from sim_bridge.fleet import Fleet
from vehicle_agent.domain.range_image import RangeImage
from vehicle_agent.mission.vehicles import HalfSphereSensor, RangeSensor
from vehicle_agent.wire.cells import pack_cells
from vehicle_agent.wire.messages import AnyMessage, BodyReport, Scan
from vehicle_agent.wire.range_blob import pack_ranges

PARTICIPANT = "simulator"
BODY_PERIOD_US = 1_000_000


class Publisher(Protocol):
    """The part of `FleetLink` that a payload needs."""

    def publish(self, message: AnyMessage, participant: str | None = None) -> None: ...


class Payload:
    """Publishes scans at each sensor's period while its vehicle is armed, and body reports once a second.

    A single beam is told by the autopilot instead, in DISTANCE_SENSOR. A scan is said by the simulator under its
    vehicle's key; of vehicles with real autopilots it says nothing.
    """

    def __init__(self, fleet: Fleet, link: Publisher, boot_id: int) -> None:
        self._fleet = fleet
        self._link = link
        self._boot_id = boot_id
        self._sequence = 0
        self._scan_due_us = [0] * len(fleet.vehicles)
        self._body_due_us = 0

    def tick(self) -> None:
        """Publish what is due; call after every step of the fleet."""
        now_us = self._fleet.clock.elapsed_us
        for index, vehicle in enumerate(self._fleet.vehicles):
            sensor = self._fleet.plan.mission.vehicles[index].sensor
            if (
                isinstance(sensor, RangeSensor | HalfSphereSensor)
                and vehicle.armed
                and now_us >= self._scan_due_us[index]
            ):
                period_us = round(sensor.period_s * 1e6)
                self._scan_due_us[index] = now_us + period_us
                self._publish_scan(index)
        if now_us >= self._body_due_us:
            self._body_due_us = now_us + BODY_PERIOD_US
            for index, table in enumerate(self._fleet.plan.mission.vehicles):
                if table.connection is None:
                    self._publish_body(index)

    def _header(self) -> dict[str, object]:
        self._sequence += 1
        return {
            "sender": PARTICIPANT,
            "boot_id": self._boot_id,
            "sequence": self._sequence,
            "stamp_ms": self._fleet.clock.unix_ms,
        }

    def _publish_scan(self, index: int) -> None:
        seen = self._fleet.scan(index)
        blob = pack_ranges(seen) if isinstance(seen, RangeImage) else pack_cells(seen)
        name = self._fleet.plan.vehicle_names[index]
        self._link.publish(Scan(**self._header(), cells=blob), participant=name)  # type: ignore[arg-type]

    def _publish_body(self, index: int) -> None:
        vehicle = self._fleet.vehicles[index]
        east, north, up = (round(metres * 100) for metres in vehicle.true_position_enu_m)
        report = BodyReport(
            **self._header(),  # type: ignore[arg-type]
            vehicle=self._fleet.plan.vehicle_names[index],
            position_cm=(east, north, up),
            armed=vehicle.armed,
            has_flown=vehicle.has_flown,
            crashed=vehicle.crashed,
            mode=vehicle.mode.name,
        )
        self._link.publish(report)
