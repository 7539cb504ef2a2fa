"""The receiving side of a mission upload: which item is wanted next, when to ask again and when to give up."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from sim_bridge.autopilot.service import Client
from sim_bridge.flight_plan import PlanItem

ASK_AGAIN_US = 1_000_000
GIVE_UP_US = 8_000_000
"""ArduPilot's waits for an item, in simulated time."""


class Due(Enum):
    """What an upload has to do now."""

    NOTHING = "nothing"
    ASK = "ask"
    GIVE_UP = "give up"


@dataclass(slots=True)
class Upload:
    """One upload of one list from one system; what has arrived counts only when all of it has.

    Attributes
    ----------
    client, system_id, component_id
        Who uploads; items from others are refused.
    wanted, last
        Sequence numbers of the item asked for and of the last one.
    items
        Those before the upload's first, if it replaces a part, and those that have arrived.
    tail
        Those behind the upload's last, if it replaces a part.
    """

    client: Client
    system_id: int
    component_id: int
    wanted: int
    last: int
    now_us: int
    items: list[PlanItem] = field(default_factory=list)
    tail: tuple[PlanItem, ...] = ()
    _heard_us: int = field(init=False)
    _asked_us: int = field(init=False)

    def __post_init__(self) -> None:
        self._heard_us = self._asked_us = self.now_us

    def is_from(self, system_id: int, component_id: int) -> bool:
        return (system_id, component_id) == (self.system_id, self.component_id)

    @property
    def complete(self) -> bool:
        return self.wanted > self.last

    def take(self, item: PlanItem, now_us: int) -> None:
        """Note the item that was wanted and want the next."""
        self.items.append(item)
        self.wanted += 1
        self._heard_us = self._asked_us = now_us

    def due(self, now_us: int) -> Due:
        """Look at the clock; asking again is noted as done."""
        if now_us - self._heard_us > GIVE_UP_US:
            return Due.GIVE_UP
        if now_us - self._asked_us > ASK_AGAIN_US:
            self._asked_us = now_us
            return Due.ASK
        return Due.NOTHING
