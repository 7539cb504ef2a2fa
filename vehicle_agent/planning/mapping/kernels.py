"""Compiles the kernels of mapping missions once and keeps the result in the cache."""

from __future__ import annotations

import numpy as np

from vehicle_agent.planning.mapping.infill import most_telling_way


def warm_up() -> None:
    """Call every kernel with the types it is used with."""
    nodes = np.array([[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]])
    most_telling_way(0.0, 0.0, nodes, np.eye(4), np.ones(4), 0.1, 10.0, 1.0)


if __name__ == "__main__":
    warm_up()
