"""What an autopilot says in its status texts; ArduPilot's words are the usual ones here."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Wording:
    """Status texts of one autopilot; empty where it says nothing.

    Attributes
    ----------
    origin_set, position_used
        While it starts up.
    armed, disarmed, crashed
        What it says then.
    arming_refused, not_ready
        With a place for `problem`: when arming is tried, and when only its checks run.
    mode_refused
        With places for `title` and `reason`.
    failsafe
        With places for the `name` of what tripped and for the `outcome`, which is empty or begins with a dash.
    controller_back, position_back
        When a failsafe is over.
    battery_low, battery_critical
        With places for `volts` and `milliampere_hours` used.
    fence_breached, fence_cleared
        With a place for the `part` of the fence.
    position_lost
        Before the failsafe is announced.
    position_failsafe
        With a place for the `title` of the mode that it has changed to.
    """

    origin_set: str = "EKF3 IMU0 origin set"
    position_used: str = "EKF3 IMU0 is using GPS"
    armed: str = "Arming motors"
    disarmed: str = "Disarming motors"
    crashed: str = "Crash: Disarming"
    arming_refused: str = "Arm: {problem}"
    not_ready: str = "PreArm: {problem}"
    mode_refused: str = "Mode change to {title} failed: {reason}"
    failsafe: str = "{name} Failsafe{outcome}"
    controller_back: str = "GCS Failsafe Cleared"
    position_back: str = "EKF Failsafe Cleared"
    battery_low: str = "Battery 1 is low {volts:.2f}V used {milliampere_hours:.0f} mAh"
    battery_critical: str = "Battery 1 is critical {volts:.2f}V used {milliampere_hours:.0f} mAh"
    fence_breached: str = "{part} fence breached"
    fence_cleared: str = "{part} fence cleared"
    position_lost: str = "EKF variance"
    position_failsafe: str = "EKF Failsafe: changed to {title} Mode"
