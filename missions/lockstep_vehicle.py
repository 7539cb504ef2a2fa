"""Joins one agent to its simulated vehicle without MAVLink: orders in, state, scans and results out."""

from __future__ import annotations

from dataclasses import replace

from sim_bridge.beam import Beam
from sim_bridge.fleet import Fleet
from sim_bridge.modes import Behaviour, LandedState
from sim_bridge.reply import Reply, VehicleSnapshot
from sim_bridge.vehicle import Vehicle
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.ports import (
    Action,
    ActionResult,
    Arm,
    AutopilotText,
    Disarm,
    FlightMode,
    GoTo,
    Hold,
    Inbox,
    Land,
    Landed,
    Order,
    ReturnHome,
    SensorScan,
    SetParameter,
    SetSpeed,
    Sounding,
    TakeOff,
    VehicleState,
)

HEARTBEAT_S = 1.0
_MODES = {
    Behaviour.GUIDED: FlightMode.GUIDED,
    Behaviour.HOLD: FlightMode.HOLD,
    Behaviour.BRAKE: FlightMode.HOLD,
    Behaviour.RETURN: FlightMode.RETURN,
    Behaviour.LAND: FlightMode.LAND,
    Behaviour.SURFACE: FlightMode.LAND,
    Behaviour.AUTO: FlightMode.MISSION,
}
_LANDED = {
    LandedState.ON_GROUND: Landed.ON_GROUND,
    LandedState.TAKING_OFF: Landed.TAKING_OFF,
    LandedState.IN_AIR: Landed.IN_AIR,
    LandedState.LANDING: Landed.LANDING,
}


class LockstepVehicle:
    """One vehicle's autopilot and sensor, as its agent meets them.

    Attributes
    ----------
    inbox
        What waits for the agent's next step.
    """

    def __init__(self, plan: MissionPlan, index: int, fleet: Fleet) -> None:
        self.inbox = Inbox()
        self._fleet, self._index = fleet, index
        self._controller_id = plan.controller_system_id(index)
        self._scan_period_s = plan.mission.vehicles[index].sensor.period_s
        self._scan_due_s = 0.0
        self._heartbeat_due_s = 0.0
        self._sounding: Sounding | None = None

    @property
    def _vehicle(self) -> Vehicle:
        return self._fleet.vehicles[self._index]

    def take_inbox(self) -> tuple[float, Inbox]:
        """The vehicle's Unix time and everything that came in since the last step."""
        snapshot = self._vehicle.snapshot
        if snapshot.time_s >= self._heartbeat_due_s:
            self._heartbeat_due_s = snapshot.time_s + HEARTBEAT_S - 1e-6
            self._vehicle.heard_controller(self._controller_id)
        if self._vehicle.beam is not None:
            if snapshot.armed:
                self._sounding = _sounding(snapshot, self._vehicle.beam)
        elif snapshot.armed and snapshot.time_s >= self._scan_due_s:
            self._scan_due_s = snapshot.time_s + self._scan_period_s - 1e-6
            self.inbox.scans.append(SensorScan(self._fleet.scan(self._index)))
        inbox, self.inbox = self.inbox, Inbox()
        inbox.state = replace(vehicle_state(snapshot), sounding=self._sounding)
        inbox.texts = [AutopilotText(text.severity, text.text) for text in self._vehicle.drain_texts()]
        return (snapshot.stamp_ms / 1000.0, inbox)

    def carry_out(self, actions: list[Action]) -> None:
        """Give orders to the vehicle; the replies are in the next inbox."""
        for action in actions:
            reply = _order(self._vehicle, action.order)
            self.inbox.results.append(ActionResult(action.action_id, reply.accepted, reply.text))


def vehicle_state(snapshot: VehicleSnapshot) -> VehicleState:
    """A simulated autopilot's snapshot in the agent's words."""
    return VehicleState(
        stamp_ms=snapshot.stamp_ms,
        position_enu_m=snapshot.position_enu_m,
        velocity_enu_m_s=snapshot.velocity_enu_m_s,
        heading_deg=snapshot.heading_deg,
        armed=snapshot.armed,
        landed=_LANDED[snapshot.landed],
        mode=_MODES.get(snapshot.behaviour, FlightMode.MANUAL),
        battery_fraction=snapshot.battery_fraction,
        ready_to_arm=snapshot.ready_to_arm,
        home_enu_m=snapshot.home_enu_m,
    )


def _sounding(snapshot: VehicleSnapshot, beam: Beam) -> Sounding:
    """A beam's last reading and when it was taken; one beyond its limits measures nothing."""
    reading_m, sensor = beam.reading_m, beam.sensor
    stamp_ms = snapshot.stamp_ms - round(1_000.0 * (snapshot.time_s - beam.read_at_s))
    within = reading_m is not None and sensor.min_range_m <= reading_m <= sensor.range_m
    return Sounding(stamp_ms, reading_m if within else None)


def _order(vehicle: Vehicle, order: Order) -> Reply:
    match order:
        case SetParameter(name, value):
            return vehicle.set_parameter(name, value)
        case Arm():
            return vehicle.arm()
        case Disarm():
            return vehicle.disarm()
        case TakeOff(height_m):
            return vehicle.take_off(height_m)
        case GoTo(position_enu_m):
            return vehicle.go_to(position_enu_m)
        case SetSpeed(speed_m_s):
            return vehicle.set_speed(speed_m_s)
        case Hold():
            return vehicle.hold()
        case ReturnHome():
            return vehicle.return_home()
        case Land():
            surfaces = Behaviour.LAND not in vehicle.personality.mode_of
            return vehicle.enter(Behaviour.SURFACE) if surfaces else vehicle.land()
