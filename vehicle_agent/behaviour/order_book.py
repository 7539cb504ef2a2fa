"""An agent's orders to its autopilot: numbered, and the last flight order given again when it was not taken."""

from __future__ import annotations

from vehicle_agent.behaviour.rhythm import Rhythm
from vehicle_agent.ports import Action, ActionResult, GoTo, Hold, Order

RETRY_S = 3.0


class OrderBook:
    """Orders of one agent, collected until the step ends."""

    def __init__(self) -> None:
        self._next_action_id = 1
        self._given: list[Action] = []
        self._flight_order: Action | None = None
        self._refused = False
        self._last_refusal = ""
        self._retry_rhythm = Rhythm(RETRY_S)

    def give(self, order: Order) -> int:
        """Queue an order; returns the number under which its result comes back."""
        action = Action(self._next_action_id, order)
        self._next_action_id += 1
        self._given.append(action)
        if isinstance(order, GoTo | Hold):
            self._flight_order, self._refused = action, False
        return action.action_id

    def retry(self, order: Order, now_s: float) -> None:
        """Give an order that is wanted until it works, at most once every `RETRY_S`."""
        if self._retry_rhythm.is_due(now_s):
            self.give(order)

    def try_at_once(self) -> None:
        """Something new is wanted: its first try need not wait."""
        self._retry_rhythm.at_once()

    def repeat_refused(self, now_s: float) -> None:
        """Give the last flight order again when the autopilot did not take it: else it would be waited for in vain."""
        if self._refused and self._flight_order is not None:
            self.retry(self._flight_order.order, now_s)

    def hear(self, result: ActionResult) -> bool:
        """Take a result; True when it is that of the last flight order."""
        if self._flight_order is None or result.action_id != self._flight_order.action_id:
            return False
        self._refused = not result.accepted
        return True

    def is_news(self, result: ActionResult) -> bool:
        """Whether a refusal differs from the last one that was told, which it then is."""
        if result.accepted or result.text == self._last_refusal:
            return False
        self._last_refusal = result.text
        return True

    def take(self) -> list[Action]:
        """Every order given since the last call."""
        given, self._given = self._given, []
        return given
