"""How long silence is taken: live, suspect, lost; on the station's clock."""

from __future__ import annotations

from ground_station.text import age
from ground_station.vehicle_picture import Condition, VehiclePicture
from vehicle_agent.wire.messages import Severity

SUSPECT_AFTER_S = 1.0
LEASE_S = 3.0
"""As the lease of the Zenoh sessions: what a dead link and a frozen agent take to be noticed."""
HEARTBEAT_S = 4.0
"""An autopilot that misses so many of its heartbeats, one a second, is not heard."""
DIED_WITHIN_S = 2.5
"""A dead program's token goes at once, that of one out of reach a whole lease after its last word."""


def next_condition(vehicle: VehiclePicture, now_s: float, speedup: float, status_period_s: float) -> Condition:
    """Condition of a vehicle at station time `now_s`.

    A status is due once per `status_period_s` of vehicle time; silence counts from the moment the next one was due.
    """
    silence_s = vehicle.age_s(now_s)
    # A token that went after the last status tells of a death at once; a status after that tells of a new life.
    token_gone = vehicle.alive is False and (vehicle.arrival_s is None or vehicle.alive_changed_s >= vehicle.arrival_s)
    if silence_s is None:
        return Condition.LOST if token_gone else Condition.AWAITED
    overdue_s = silence_s - status_period_s / max(1.0, speedup)
    if token_gone or overdue_s > LEASE_S:
        return Condition.LEFT if vehicle.finished else Condition.LOST
    if overdue_s > SUSPECT_AFTER_S:
        return Condition.LEFT if vehicle.finished else Condition.SUSPECT
    return Condition.LIVE


def agent_died(vehicle: VehiclePicture) -> bool:
    """Its liveliness token went while it was still heard; after a whole silent lease, the link took it away."""
    if vehicle.alive is not False:
        return False
    return vehicle.arrival_s is None or vehicle.alive_changed_s - vehicle.arrival_s < DIED_WITHIN_S


def autopilot_words(vehicle: VehiclePicture, now_s: float) -> str:
    """What is known of the autopilot of a vehicle whose agent is not heard: empty where nobody listens to MAVLink."""
    autopilot = vehicle.autopilot
    if autopilot is None:
        return ""
    if now_s - autopilot.heard_s > HEARTBEAT_S:
        return ", and its autopilot is not heard either"
    failsafe = ", under its failsafe" if autopilot.in_failsafe else ""
    return f", its autopilot lives ({'armed' if autopilot.armed else 'disarmed'}{failsafe})"


def transition_text(vehicle: VehiclePicture, condition: Condition, now_s: float) -> tuple[Severity, str, str] | None:
    """Severity, code and text of the log entry that a change of condition deserves; None when it is not news."""
    if condition is Condition.LOST:
        silence_s = vehicle.age_s(now_s)
        heard = "never heard" if silence_s is None else f"last heard {age(silence_s)} ago"
        heard += autopilot_words(vehicle, now_s)
        if agent_died(vehicle):
            text = f"lost: its agent is gone, {heard}; the autopilot's failsafe takes over"
        else:
            text = f"lost: out of reach or frozen, {heard}; what flies on, flies by itself"
        return (Severity.ERROR, "lost", text)
    if vehicle.condition is Condition.LOST and condition is Condition.LIVE:
        return (Severity.NOTICE, "found", f"heard again after {age(now_s - vehicle.condition_since_s)}")
    return None
