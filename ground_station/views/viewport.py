"""Which piece of the mission's plane a map shows, in square pixels."""

from __future__ import annotations

from dataclasses import dataclass

from vehicle_agent.domain.grid import Grid


@dataclass(frozen=True, slots=True)
class Viewport:
    """Pixels over the plane; pixel (0, 0) is the north-western corner, x grows to the east and y to the south.

    Attributes
    ----------
    west_m, north_m
        The north-western corner, ENU metres.
    pixel_width_m, pixel_height_m
        Ground under one pixel.
    width, height
        In pixels.
    """

    west_m: float
    north_m: float
    pixel_width_m: float
    pixel_height_m: float
    width: int
    height: int

    @classmethod
    def around(cls, grid: Grid, width: int, height: int, pixel_aspect: float = 1.0) -> Viewport:
        """The smallest view of the whole grid, centred.

        Parameters
        ----------
        width, height
            In pixels.
        pixel_aspect
            Height of a pixel on the screen over its width: 1 for half blocks, 2 for whole characters.
        """
        extent_east_m, extent_north_m = grid.east_m - grid.west_m, grid.north_m - grid.south_m
        pixel_m = max(extent_east_m / max(1, width), extent_north_m / max(1, height) / pixel_aspect)
        west_m = (grid.west_m + grid.east_m - width * pixel_m) / 2
        north_m = (grid.south_m + grid.north_m + height * pixel_m * pixel_aspect) / 2
        return cls(west_m, north_m, pixel_m, pixel_m * pixel_aspect, width, height)

    def pixel_of(self, east_m: float, north_m: float) -> tuple[int, int]:
        """Column and row of the pixel that holds a point; may lie outside the view."""
        return (
            int((east_m - self.west_m) // self.pixel_width_m),
            int((self.north_m - north_m) // self.pixel_height_m),
        )

    def holds(self, x: int, y: int) -> bool:
        return 0 <= x < self.width and 0 <= y < self.height
