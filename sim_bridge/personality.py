"""What differs between autopilots: numbers, names, texts, parameters and what those mean."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum, IntEnum

from sim_bridge.modes import Behaviour, ModeTraits
from sim_bridge.parameters import Parameter, ParameterTable
from sim_bridge.wording import Wording


class Action(Enum):
    """What a failsafe does."""

    WARN = "warn"
    DISARM = "disarm"
    HOLD = "hold"
    DEPTH_HOLD = "depth hold"
    BRAKE = "brake"
    RETURN = "return"
    LAND = "land"
    SURFACE = "surface"


ACTION_BEHAVIOURS = {
    Action.HOLD: Behaviour.HOLD,
    Action.DEPTH_HOLD: Behaviour.DEPTH_HOLD,
    Action.BRAKE: Behaviour.BRAKE,
    Action.RETURN: Behaviour.RETURN,
    Action.LAND: Behaviour.LAND,
    Action.SURFACE: Behaviour.SURFACE,
}


@dataclass(frozen=True, slots=True)
class FenceSettings:
    """What the vehicle's parameters say about its fence; None switches a part off, no action all of it.

    Attributes
    ----------
    lowest_m, highest_m
        Heights above home.
    radius_m
        Distance over ground from home.
    zones
        Whether the uploaded polygons and circles count.
    """

    action: Action | None = None
    lowest_m: float | None = None
    highest_m: float | None = None
    radius_m: float | None = None
    zones: bool = False


@dataclass(frozen=True, slots=True)
class Settings:
    """What the parameters mean, whatever they are called: metres, seconds, degrees, milliampere hours.

    Attributes
    ----------
    speed_m_s, climb_m_s, sink_m_s, acceleration_m_s2, vertical_acceleration_m_s2
        Limits of the body in automatic flight.
    turn_radius_m
        Tightest turn of a vessel.
    arrival_radius_m
        Distance at which a waypoint counts as reached.
    takeoff_height_m
        Height above home of a take-off that names none.
    return_speed_m_s
        0: `speed_m_s`.
    land_speed_m_s, land_speed_high_m_s, land_slow_below_m
        Sink rate at touchdown, before (0: `sink_m_s`), and the height at which the one follows the other.
    disarm_delay_s, landed_disarm_delay_s
        How long motors idle on the ground, before a flight and after a landing (0 before a flight: for ever).
    target_timeout_s
        How long a velocity target lasts, and with `positions_expire` a position target.
    expired_target_action
        What follows then; None: stop and stay in that mode.
    controller_id
        Whose heartbeats are watched; None: anybody's.
    controller_action, low_battery_action, critical_battery_action, lost_position_action, leak_action
        None switches the failsafe off.
    continue_landing, continue_piloted
        Where the controller's silence is ignored.
    surface_depth_m
        Depth above which an underwater vehicle is at the surface.
    bottom_tracking_depth_m
        Depth below which it follows the bottom.
    """

    speed_m_s: float
    climb_m_s: float
    sink_m_s: float
    acceleration_m_s2: float
    vertical_acceleration_m_s2: float
    arrival_radius_m: float
    turn_radius_m: float = 0.0
    takeoff_height_m: float = 0.0
    return_height_m: float = 0.0
    return_climb_min_m: float = 0.0
    return_cone_slope: float = 0.0
    return_speed_m_s: float = 0.0
    return_loiter_s: float = 0.0
    land_speed_m_s: float = 0.5
    land_speed_high_m_s: float = 0.0
    land_slow_below_m: float = 10.0
    disarm_delay_s: float = 0.0
    landed_disarm_delay_s: float = 0.0
    target_timeout_s: float = 3.0
    positions_expire: bool = False
    expired_target_action: Action | None = None
    controller_id: int | None = 255
    controller_timeout_s: float = 5.0
    controller_action: Action | None = None
    continue_landing: bool = False
    continue_piloted: bool = False
    capacity_mah: float = 5000.0
    low_mah: float = 0.0
    critical_mah: float = 0.0
    low_battery_action: Action | None = None
    critical_battery_action: Action | None = None
    lost_position_action: Action | None = None
    leak_action: Action | None = None
    surface_depth_m: float = 0.1
    bottom_tracking_depth_m: float = 0.5
    fence: FenceSettings = FenceSettings()


@dataclass(frozen=True)
class Personality:
    """One autopilot's way to be a vehicle of one kind.

    Attributes
    ----------
    name
        Of its firmware.
    mav_type, autopilot
        As in its heartbeat.
    modes
        Its flight modes by number, each a member of an IntEnum.
    mode_of
        The mode that it takes for a behaviour.
    start_mode, mode_after_start
        At boot, and once it has started up; None: it stays in the one.
    base_mode_piloted, base_mode_automatic
        MAV_MODE_FLAG bits of its heartbeat, without the armed bit.
    parameters
        Rows of its table; read their meaning only through `settings`.
    bytewise_parameters
        Integers travel as the bytes of a float field, not as its value.
    guided_behaviour
        Behaviour in which DO_REPOSITION is followed.
    takes_off_in_guided
        Whether a take-off needs the guided mode first; if not, it is a mode of its own.
    takeoff_altitude_amsl
        Whether MAV_CMD_NAV_TAKEOFF counts from the sea instead of from home.
    packed_modes
        Whether MAV_CMD_DO_SET_MODE carries main and sub mode in parameters 2 and 3.
    fresh_targets_first
        Whether targets must flow before their mode can be entered.
    capabilities, flight_software_version, banner
        As in AUTOPILOT_VERSION and after DO_SEND_BANNER.
    wording
        Its status texts.
    reports_landed_state
        Whether EXTENDED_SYS_STATE tells more than UNDEFINED.
    system_id_parameter
        Which parameter is its MAVLink system id.
    """

    name: str
    mav_type: int
    autopilot: int
    modes: Mapping[IntEnum, ModeTraits]
    mode_of: Mapping[Behaviour, IntEnum]
    start_mode: IntEnum
    base_mode_piloted: int
    base_mode_automatic: int
    parameters: tuple[Parameter, ...]
    settings: Callable[[ParameterTable], Settings]
    capabilities: int
    flight_software_version: int
    banner: tuple[str, ...]
    bytewise_parameters: bool = False
    guided_behaviour: Behaviour = Behaviour.GUIDED
    takes_off_in_guided: bool = True
    packed_modes: bool = False
    takeoff_altitude_amsl: bool = False
    fresh_targets_first: bool = False
    wording: Wording = field(default_factory=Wording)
    reports_landed_state: bool = True
    mode_after_start: IntEnum | None = None
    system_id_parameter: str = "SYSID_THISMAV"
    _by_number: dict[int, IntEnum] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self._by_number.update({int(mode): mode for mode in self.modes})

    def mode(self, number: int) -> IntEnum | None:
        """The mode of that number, None when there is none."""
        return self._by_number.get(number)
