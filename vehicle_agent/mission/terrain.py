"""The ground that a mission's simulator puts under its vehicles."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from vehicle_agent.mission.tables import LINE_PATTERN, AltitudeM, Positive, Table


class GridTerrain(Table, frozen=True, kw_only=True, tag_field="kind", tag="grid"):
    """Measured terrain from an .npz file: `elevation_amsl_m` (columns, rows), `west_m`, `south_m`, `cell_m`.

    Attributes
    ----------
    file
        Path relative to the mission file.
    """

    file: Annotated[str, Meta(pattern=LINE_PATTERN, min_length=1, max_length=1000)]


class GaussianTerrain(Table, frozen=True, kw_only=True, tag_field="kind", tag="gaussians"):
    """Hills drawn from the mission's seed.

    Attributes
    ----------
    peaks
        Number of Gaussians, centres uniform over the area.
    height_m
        Lowest and highest peak.
    sigma_m
        Standard deviation of each.
    """

    peaks: Annotated[int, Meta(ge=1, le=1000)]
    height_m: tuple[Annotated[float, Meta(ge=0, le=12_000)], Annotated[float, Meta(ge=0, le=12_000)]]
    sigma_m: Positive


class FlatTerrain(Table, frozen=True, kw_only=True, tag_field="kind", tag="flat"):
    """Level ground.

    Attributes
    ----------
    elevation_amsl_m
        Height of the ground above mean sea level.
    """

    elevation_amsl_m: AltitudeM = 0.0


Share = Annotated[float, Meta(ge=0, le=1)]


class TownTerrain(Table, frozen=True, kw_only=True, tag_field="kind", tag="town"):
    """Buildings on level ground at local `up` zero, along streets, some with overhangs, passages and bridges.

    Attributes
    ----------
    file
        Path of an .npz file, relative to the mission file, that holds `solid` (columns, rows, layers), true where
        something is, on the voxels of the area; left out, the town is drawn from the mission's seed.
    block_m
        From the middle of one street to that of the next.
    street_m
        Narrowest and widest street.
    height_m
        Lowest and highest building.
    overhang_share, passage_share, bridge_share
        Share of the buildings that have each.
    square_share
        Share of the blocks that stay empty, beside the one in the south-west.
    """

    file: Annotated[str, Meta(pattern=LINE_PATTERN, min_length=1, max_length=1000)] | None = None
    block_m: Positive = 30.0
    street_m: tuple[Positive, Positive] = (8.0, 12.0)
    height_m: tuple[Positive, Positive] = (6.0, 22.0)
    overhang_share: Share = 0.4
    passage_share: Share = 0.3
    bridge_share: Share = 0.25
    square_share: Share = 0.1


Terrain = GridTerrain | GaussianTerrain | FlatTerrain | TownTerrain
