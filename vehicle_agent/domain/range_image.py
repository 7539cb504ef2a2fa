"""What a sensor of many rays measured at one instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.polygon import BoolArray


@dataclass(frozen=True, slots=True)
class RangeImage:
    """Distances along the rays of a sensor, in the order of its fan.

    Attributes
    ----------
    sensor_enu_m
        Where the sensor was.
    ranges_m
        (R,) float32, how far each ray was followed.
    returned
        (R,) bool, whether it met something there.
    stamp_ms
        When, milliseconds of the vehicle's Unix time.
    """

    sensor_enu_m: Point
    ranges_m: npt.NDArray[np.float32]
    returned: BoolArray
    stamp_ms: int

    def __len__(self) -> int:
        return len(self.ranges_m)
