"""Wind, gusts and currents around the fleet, from the mission's seed."""

from __future__ import annotations

import math

import numpy as np

from sim_bridge.dynamics import Bodies, BodyKind
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.mission.model import SimulationTable

GUST_TIME_S = 3.0
"""Correlation time of a gust (Dryden's at a few metres a second and some tens of metres above ground)."""


class Environment:
    """Moves the air and the water; gusts are an Ornstein-Uhlenbeck process of each vehicle's own.

    `streams`: one generator per vehicle, so that another vehicle changes nobody's weather.
    """

    def __init__(self, table: SimulationTable, bodies: Bodies, streams: list[np.random.Generator]) -> None:
        self._bodies = bodies
        self._streams = streams
        self._gust_m_s = table.gust_m_s
        in_air = bodies.kind == BodyKind.MULTICOPTER
        self._mean_m_s: FloatArray = np.where(in_air[:, None], table.wind_m_s, table.current_m_s).astype(np.float64)
        self._gusty = in_air & (table.gust_m_s > 0.0)
        self._still = not self._gusty.any()
        bodies.flow_m_s[:] = self._mean_m_s
        bodies.flows_m_s = bodies.flow_m_s.tolist()

    def advance(self, dt_s: float) -> None:
        """Let the weather change by one step."""
        if self._still:
            return
        keep = math.exp(-dt_s / GUST_TIME_S)
        spread = self._gust_m_s * math.sqrt(1.0 - keep * keep)
        bodies = self._bodies
        for index in np.flatnonzero(self._gusty):
            bodies.gust_m_s[index] = keep * bodies.gust_m_s[index] + spread * self._streams[index].standard_normal(2)
        np.add(self._mean_m_s, bodies.gust_m_s, out=bodies.flow_m_s)
        bodies.flows_m_s = bodies.flow_m_s.tolist()
