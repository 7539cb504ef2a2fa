"""A single beam fixed to a body, straight down through its keel: an echo sounder or a rangefinder."""

from __future__ import annotations

import math

import numpy as np

from sim_bridge.dynamics import Bodies
from vehicle_agent.domain.frames import Point
from vehicle_agent.mission.vehicles import SingleBeamSensor


class Beam:
    """Measures at its own period, so that who listens, and how often, changes no reading.

    Attributes
    ----------
    sensor
        Its limits and its noise.
    reading_m
        Last distance along the beam; infinite while nothing within range answers, below `sensor.min_range_m` when the
        ground is too near to be measured. None before the first reading.
    read_at_s
        When that was, in simulated seconds.
    """

    def __init__(self, sensor: SingleBeamSensor, bodies: Bodies, index: int, stream: np.random.Generator) -> None:
        self.sensor = sensor
        self.reading_m: float | None = None
        self._bodies = bodies
        self._index = index
        self._stream = stream
        self._due_s = self.read_at_s = 0.0

    def advance(self, time_s: float) -> None:
        """Measure when the period has passed."""
        if time_s < self._due_s - 1e-6:
            return
        self._due_s, self.read_at_s = time_s + self.sensor.period_s, time_s
        distance_m = self._bodies.distance_along_m(self._index, self._direction_enu(), self.sensor.range_m)
        # Kapoutsis 2015, eq. 24: the noise is a share of the distance.
        self.reading_m = distance_m * max(0.0, 1.0 + self.sensor.noise_fraction * float(self._stream.standard_normal()))

    def _direction_enu(self) -> Point:
        """The body's downward axis."""
        roll, pitch = self._bodies.attitude_rad[self._index].tolist()
        heading = math.radians(float(self._bodies.heading_deg[self._index]))
        forward, rightward = math.cos(roll) * math.sin(pitch), -math.sin(roll)
        return (
            forward * math.sin(heading) + rightward * math.cos(heading),
            forward * math.cos(heading) - rightward * math.sin(heading),
            -math.cos(roll) * math.cos(pitch),
        )
