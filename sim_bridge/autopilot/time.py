"""SYSTEM_TIME and TIMESYNC: the vehicle's clock."""

from __future__ import annotations

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, MessageBuilder, MessageHandler, Service


class TimeService(Service):
    """Tells simulated time, as Unix time and since boot."""

    def handlers(self) -> dict[str, MessageHandler]:
        return {"TIMESYNC": self._on_timesync}

    def builders(self) -> dict[int, MessageBuilder]:
        return {mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: self.system_time}

    def system_time(self) -> Message:
        clock = self.node.vehicle.clock
        unix_us = clock.unix_us if self.node.vehicle.origin_enu_m is not None else 0
        return mavlink.MAVLink_system_time_message(unix_us, self.node.time_boot_ms)

    def _on_timesync(self, client: Client, message: Message) -> None:
        if message.tc1 == 0:
            boot_ns = self.node.time_boot_us * 1000
            self.node.send(client, mavlink.MAVLink_timesync_message(boot_ns, message.ts1))
