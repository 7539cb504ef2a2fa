"""AVAILABLE_MODES tells the flight modes one by one when asked; the monitor tells that they stay the same."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import (
    AVAILABLE_MODES_ID,
    AVAILABLE_MODES_MONITOR_ID,
    Message,
    available_modes_message,
    available_modes_monitor_message,
    mavlink,
)
from sim_bridge.autopilot.service import CommandRequest, MessageBuilder, Responder, Service
from sim_bridge.modes import Behaviour

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

MONITOR_INTERVAL_US = 5_000_000
STANDARD_MODES = {
    Behaviour.HOLD: mavlink.MAV_STANDARD_MODE_POSITION_HOLD,
    Behaviour.AUTO: mavlink.MAV_STANDARD_MODE_MISSION,
    Behaviour.RETURN: mavlink.MAV_STANDARD_MODE_SAFE_RECOVERY,
    Behaviour.LAND: mavlink.MAV_STANDARD_MODE_LAND,
    Behaviour.TAKE_OFF: mavlink.MAV_STANDARD_MODE_TAKEOFF,
}


class AvailableModesService(Service):
    """Whoever asks hears all modes; from then on every client hears the monitor."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._monitor_due_us: int | None = None

    def builders(self) -> dict[int, MessageBuilder]:
        return {AVAILABLE_MODES_MONITOR_ID: self.monitor}

    def responders(self) -> dict[int, Responder]:
        return {AVAILABLE_MODES_ID: self._requested}

    def tick(self) -> None:
        now_us = self.node.vehicle.clock.elapsed_us
        if self._monitor_due_us is not None and now_us >= self._monitor_due_us:
            self._monitor_due_us = now_us + MONITOR_INTERVAL_US
            self.node.broadcast(available_modes_monitor_message(0))

    def monitor(self) -> Message:
        if self._monitor_due_us is None:
            self._monitor_due_us = self.node.vehicle.clock.elapsed_us + MONITOR_INTERVAL_US
        return available_modes_monitor_message(0)

    def _requested(self, request: CommandRequest) -> list[Message]:
        """All modes, or the one whose number stands in parameter 2."""
        wanted = request.parameters[1]
        numbers = [int(wanted)] if 1 <= wanted <= 255 else range(1, 256)
        return [message for index in numbers if (message := self.mode(index)) is not None]

    def mode(self, index: int) -> Message | None:
        """The mode of a number from 1 on; None when there are not so many."""
        self.monitor()
        modes = list(self.node.vehicle.personality.modes.items())
        if not 1 <= index <= len(modes):
            return None
        mode, traits = modes[index - 1]
        standard = STANDARD_MODES.get(traits.behaviour, mavlink.MAV_STANDARD_MODE_NON_STANDARD)
        return available_modes_message(len(modes), index, standard, int(mode), 0, traits.title.encode("ascii"))
