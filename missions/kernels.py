"""Compiles every kernel of a simulated fleet into the cache, before anything flies: `python -m missions.kernels`.

With `town` as its argument, those of missions in towns too.
"""

from __future__ import annotations

import sys

import sim_bridge.kernels
import vehicle_agent.domain.kernels

TOWN = "town"


def main() -> None:
    vehicle_agent.domain.kernels.warm_up()
    sim_bridge.kernels.warm_up()
    if TOWN in sys.argv[1:]:
        from vehicle_agent.domain import town_kernels  # loads slowly: only where there is a town

        town_kernels.warm_up()
        sim_bridge.kernels.warm_up_town()


if __name__ == "__main__":
    main()
