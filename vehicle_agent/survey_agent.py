"""The agent of a vehicle that maps landmarks: hears its echo sounder, and shares what it learned over a thin link."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from vehicle_agent.agent import VehicleAgent
from vehicle_agent.behaviour.depth_navigator import DepthNavigator
from vehicle_agent.behaviour.drift import Drift
from vehicle_agent.behaviour.landmark_share import LandmarkShare
from vehicle_agent.behaviour.landmark_talk import HEADER_BYTES, LandmarkTalk
from vehicle_agent.behaviour.map_exchange import encode_record
from vehicle_agent.behaviour.modem import Modem
from vehicle_agent.behaviour.rhythm import Rhythm
from vehicle_agent.behaviour.shared_map import SharedMap
from vehicle_agent.behaviour.units import to_metres
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.talk import PACKETS_PER_STATUS, packet_of
from vehicle_agent.mission.tasks import MapTask
from vehicle_agent.mission.vehicles import SingleBeamSensor
from vehicle_agent.planning.mapping.choose import make_mapping_planner, urgent_within_m
from vehicle_agent.ports import Action, GoTo, Inbox, Outbox, Sounding, VehicleState
from vehicle_agent.wire.keys import TOPIC_BY_NAME
from vehicle_agent.wire.messages import AnyMessage, LandmarkDigest, Landmarks, Stage

SOUNDING_STAGES = (Stage.WORKING, Stage.HOLDING, Stage.RETURNING)
LEAST_TEAMMATE_SD_M = 0.3
"""However well a teammate says it knows where it is."""
SAME_READING = 0.6
"""A reading that comes sooner than this share of the sensor's period is the last one, told again."""


class SurveyAgent(VehicleAgent):
    """Decides for one vehicle of a team that maps; parameters as of `VehicleAgent`."""

    def __init__(
        self,
        plan: MissionPlan,
        index: int,
        boot_id: int,
        rng: np.random.Generator,
        journal_records: Iterable[bytes] = (),
    ) -> None:
        sensor = plan.mission.vehicles[index].sensor
        assert isinstance(sensor, SingleBeamSensor)
        self._modem = Modem(*packet_of(plan))
        self._packets = 0
        self._checksum_rhythm = Rhythm(TOPIC_BY_NAME["landmark-digest"].period_s or 60.0)
        self._next_reading_ms = 0
        self._between_readings_ms = 1000.0 * sensor.period_s * SAME_READING
        task = plan.mission.task
        self._mends = isinstance(task, MapTask) and task.ranging
        self._teammates = frozenset(plan.vehicle_names) - {plan.vehicle_names[index]}
        self._ranged: dict[str, tuple[int, int]] = {}
        super().__init__(plan, index, boot_id, rng, journal_records)

    @property
    def refused(self) -> int:
        """Records, packets and messages that were heard and dropped."""
        return sum(self._talk.refused.values()) + sum(self._share.refused.values()) + self._modem.dropped

    def step(self, now_s: float, inbox: Inbox) -> Outbox:
        if self._mends:
            self._hear_ranges(inbox)
        if inbox.state is not None:
            self._drift.watch(max(self._now_s, now_s), inbox.state)
            inbox.state = _shifted(inbox.state, self._drift.correction_m)
            self._sound(inbox.state.sounding)
        self.messages_dropped += self.refused
        outbox = super().step(now_s, inbox)
        self._modem.put(outbox.messages)
        if self._modem.is_open(self._now_s) and self._state is not None:
            self._fill_packet(self._state)
        actions = [_as_reckoned(action, self._drift.correction_m) for action in outbox.actions]
        return Outbox(outbox.journal, actions, self._modem.take(self._now_s))

    def _outfit(self, plan: MissionPlan, index: int, rng: np.random.Generator) -> tuple[SharedMap, DepthNavigator]:
        mission, vehicle = plan.mission, plan.mission.vehicles[index]
        assert isinstance(mission.task, MapTask)
        self._share = LandmarkShare(plan, index)
        self._talk = LandmarkTalk(
            self._share, plan.vehicle_names, index, mission.task.capacity, urgent_within_m(mission.task)
        )
        depth_m = vehicle.depth_m or 0.0
        self._drift = Drift(
            mission.simulation.water_level_m, 2.0 * depth_m / vehicle.climb_m_s, mission.task.accurate_sd_m
        )
        self._silence_s = mission.safety.teammate_silence_s
        planner = make_mapping_planner(plan, index)
        self._navigator = DepthNavigator(plan, index, planner, self._share, self._talk, self._drift)
        return self._share, self._navigator

    def _hear_ranges(self, inbox: Inbox) -> None:
        """Mend the position by ranges to teammates whose packets came with them, each once."""
        packets = {(told.sender, told.sequence): told for told in inbox.messages if isinstance(told, Landmarks)}
        for measured in inbox.ranges:
            packet = packets.get((measured.sender, measured.sequence))
            if packet is None or packet.sender not in self._teammates:
                continue
            identity = (packet.boot_id, packet.sequence)
            if self._ranged.get(packet.sender) == identity:
                continue
            self._ranged[packet.sender] = identity
            sd_m = max(packet.position_sd_cm / 100.0, LEAST_TEAMMATE_SD_M)
            self._drift.hear_range(measured.range_m, packet.stamp_ms, to_metres(packet.position_cm), sd_m)

    def _sound(self, sounding: Sounding | None) -> None:
        """Fold a new reading of the echo sounder in, taken under way, where the vehicle was at that moment."""
        if sounding is None or sounding.range_m is None or self.stage not in SOUNDING_STAGES:
            return
        if sounding.stamp_ms < self._next_reading_ms:
            return
        self._next_reading_ms = round(sounding.stamp_ms + self._between_readings_ms)
        self._share.sound(self._drift.place_at(sounding.stamp_ms), sounding.range_m, self._drift.unfixed_s)

    def _hear(self, message: AnyMessage) -> None:
        if message.sender == self.name:
            return
        match message:
            case Landmarks():
                here_enu_m = to_metres(message.position_cm) if self._state is None else self._state.position_enu_m
                self._talk.hear(message, self._now_s, here_enu_m)
                self._knowledge.team.hear_of(message.sender, self._now_s)
            case LandmarkDigest():
                self._talk.hear_digest(message)
            case _:
                super()._hear(message)

    def _report(self) -> list[bytes]:
        """Keep what was measured in the journal; what is said waits for the modem."""
        if self._map_rhythm.is_due(self._now_s) and (record := self._knowledge.exchange.next_record()) is not None:
            return [encode_record(record)]
        return []

    def _fill_packet(self, state: VehicleState) -> None:
        """Say what the next packet has room for: in turn the landmarks and the status, checksums now and then."""
        if self._modem.room_bytes() < HEADER_BYTES + 2 * len(self.name):
            return
        self._packets += 1
        if self._packets % PACKETS_PER_STATUS == 1:
            self._say_status(state)
        else:
            waypoint = self._navigator.waypoint
            fields = self._talk.fields(
                state.position_enu_m,
                self._drift.position_sd_m,
                None if waypoint is None else waypoint.goal_enu_m,
                self._talk.teammates(self._now_s, self._silence_s),
                self._modem.room_bytes(),
            )
            self._voice.say(Landmarks, **fields)
        if self._checksum_rhythm.is_due(self._now_s):
            self._voice.say(LandmarkDigest, checksums=self._talk.digest())
        self._modem.put(self._voice.take())


def _shifted(state: VehicleState, correction_m: tuple[float, float]) -> VehicleState:
    """A state with the position mended."""
    east_m, north_m, up_m = state.position_enu_m
    return replace(state, position_enu_m=(east_m + correction_m[0], north_m + correction_m[1], up_m))


def _as_reckoned(action: Action, correction_m: tuple[float, float]) -> Action:
    """An order whose target the autopilot reaches by its own, unmended reckoning."""
    if not isinstance(action.order, GoTo):
        return action
    east_m, north_m, up_m = action.order.position_enu_m
    return replace(action, order=GoTo((east_m - correction_m[0], north_m - correction_m[1], up_m)))
