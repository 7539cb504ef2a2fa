"""Compiles every kernel of a simulated fleet into the cache, before anything flies: `python -m missions.kernels`."""

from __future__ import annotations

import sim_bridge.kernels
import vehicle_agent.domain.kernels


def main() -> None:
    vehicle_agent.domain.kernels.warm_up()
    sim_bridge.kernels.warm_up()


if __name__ == "__main__":
    main()
