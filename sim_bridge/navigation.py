"""How far each vehicle's belief of its position is from the truth.

With a fix the error is that of a satellite receiver: a slow Gauss-Markov wander. Without one, under water or with the
receiver gone, the vehicle reckons its way from a velocity that is wrong by a constant drawn anew at each loss and by
noise, so that the error grows with the time without recalibration (Kapoutsis 2015, eq. 4: h_xi depends on t_uw). The
next fix sets it right again. Depth comes from a pressure sensor and stays good.
"""

from __future__ import annotations

import math

import numpy as np

from sim_bridge.dynamics import Bodies, BodyKind, Motion
from vehicle_agent.domain.frames import FloatArray

PERIOD_S = 0.2
"""Between two fixes, and between two draws."""
WANDER_TIME_S = 30.0
VERTICAL_SHARE = 0.5
"""Vertical noise against horizontal; the barometer helps."""
FIX_DEPTH_M = 0.5
"""An antenna deeper than this hears nothing."""
RECKONING_BIAS_M_S = {BodyKind.MULTICOPTER: 0.3, BodyKind.SURFACE_VESSEL: 0.1, BodyKind.UNDERWATER: 0.03}
"""Standard deviation of the velocity's constant error: inertial alone, with a speed log, with a Doppler log."""
AT_REST_M_S = 0.01
"""A vehicle without thrust and slower than this knows that it stands: its reckoning goes no further astray."""
RECKONING_NOISE_M_S = 0.05
"""Random walk of the reckoned position, per square root of a second."""


class Navigation:
    """Keeps `Bodies.error_m`; `streams`: one generator per vehicle.

    Attributes
    ----------
    receiver_failed
        (N,) bool, satellites lost by fault.
    """

    def __init__(self, bodies: Bodies, noise_m: float, streams: list[np.random.Generator]) -> None:
        count = len(bodies.kind)
        self.receiver_failed = np.zeros(count, dtype=np.bool_)
        self._bodies = bodies
        self._noise_m = noise_m
        self._streams = streams
        self._bias_m_s: FloatArray = np.zeros((count, 2))
        self._reckons = np.zeros(count, dtype=np.bool_)
        self._since_s = 0.0
        self._underwater = bodies.kind == BodyKind.UNDERWATER
        vertical = np.where(self._underwater, 0.0, VERTICAL_SHARE)
        self._spread_m: FloatArray = noise_m * np.column_stack((np.ones((count, 2)), vertical))
        if noise_m > 0.0:
            for index, stream in enumerate(streams):
                bodies.error_m[index] = self._spread_m[index] * stream.standard_normal(3)

    def has_fix(self, index: int) -> bool:
        return not self._reckons[index]

    def advance(self, dt_s: float) -> None:
        """Let errors grow, wander or vanish by one step."""
        self._since_s += dt_s
        if self._since_s < PERIOD_S - 1e-9:
            return
        period_s, self._since_s = self._since_s, 0.0
        bodies = self._bodies
        deep = self._underwater & (bodies.position_enu_m[:, 2] < bodies.water_level_m - FIX_DEPTH_M)
        lost = self.receiver_failed | deep
        if not lost.any() and not self._reckons.any() and self._noise_m == 0.0:
            return
        at_rest = (bodies.motion == Motion.OFF) & (np.abs(bodies.velocity_enu_m_s).max(axis=1) < AT_REST_M_S)
        keep = math.exp(-period_s / WANDER_TIME_S)
        for index, stream in enumerate(self._streams):
            error = bodies.error_m[index]
            if lost[index]:
                if not self._reckons[index]:
                    bias = RECKONING_BIAS_M_S[BodyKind(int(bodies.kind[index]))]
                    self._bias_m_s[index] = bias * stream.standard_normal(2)
                if at_rest[index]:
                    continue
                step = RECKONING_NOISE_M_S * math.sqrt(period_s) * stream.standard_normal(2)
                error[:2] += self._bias_m_s[index] * period_s + step
            elif self._reckons[index]:
                error[:] = self._spread_m[index] * stream.standard_normal(3)
            elif self._noise_m > 0.0:
                draw = stream.standard_normal(3)
                error[:] = keep * error + math.sqrt(1.0 - keep * keep) * self._spread_m[index] * draw
        self._reckons = lost
