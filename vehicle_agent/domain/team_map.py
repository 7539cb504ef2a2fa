"""What all maps of a team have in common, whatever they are made of."""

from __future__ import annotations

from typing import Any, Protocol, Self

import numpy.typing as npt

from vehicle_agent.domain.polygon import BoolArray


class TeamMap(Protocol):
    """A map that merges: commutatively, associatively and idempotently."""

    @property
    def observed(self) -> BoolArray:
        """What of the surface is known: (columns, rows) or (columns, rows, layers) bool."""
        ...

    def first_observer_share(self, observer: int, within: BoolArray | None = None) -> float:
        """J_E of one vehicle (Renzaglia 2020 eq. 5)."""
        ...

    def merge(self, other: Self) -> None:
        """Join another map of the same kind and grid into this one."""
        ...

    def copy(self) -> Self:
        """A map of its own with the same content."""
        ...

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Everything in it as named arrays, to be kept in a file."""
        ...
