"""What a mission asks of its team: to explore, to cover or to map."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from vehicle_agent.mission.tables import Table

PlannerName = Literal["tours", "lanes", "claims", "fcao", "cao", "closest-frontier", "greedy"]

DEFAULT_PLANNER: PlannerName = "lanes"


class ExploreTask(Table, frozen=True, kw_only=True, tag_field="kind", tag="explore"):
    """See the whole surface of the area once.

    Attributes
    ----------
    planner
        Who decides where to go next; left out, lanes, and in towns tours.
    step_m
        Longest way between two decisions (alpha in Renzaglia eq. 10).
    """

    planner: PlannerName | None = None
    step_m: Annotated[float, Meta(ge=1, le=1e6)] = 100.0


CoverPlannerName = Literal["stations", "cao"]


class CoverTask(Table, frozen=True, kw_only=True, tag_field="kind", tag="cover"):
    """Find the places from which the team sees most of the area at once, and stay there.

    Of hills the area's cells count, of towns the faces of walls, roofs and ground.

    Attributes
    ----------
    planner
        Who decides where to go next.
    step_m
        Longest way between two decisions (alpha_0 in Renzaglia eq. 11).
    hold_s
        Vehicle time that the team stays on its places, once all have settled, before it returns; it returns at
        `stop.time_limit_s` in any case.
    explore_first
        See `stop.observed_fraction` of the area before covering it.
    known_points_enu_m
        Points of the surface, [east, north, up], that are known beforehand; the team first spreads over them by a
        constrained Voronoi tessellation (Renzaglia section 5.1). Not in towns.
    """

    planner: CoverPlannerName = "stations"
    step_m: Annotated[float, Meta(ge=1, le=1e6)] = 100.0
    hold_s: Annotated[float, Meta(ge=1, le=1e6)] = 30.0
    explore_first: bool = False
    known_points_enu_m: Annotated[tuple[tuple[float, float, float], ...], Meta(max_length=10_000)] = ()


MapPlannerName = Literal["survey", "viewpoints"]


class MapTask(Table, frozen=True, kw_only=True, tag_field="kind", tag="map"):
    """Estimate the height of a landmark in every cell of the area and draw the map from them (Kapoutsis 2015).

    Attributes
    ----------
    planner
        Who decides where to go next: `survey` sails lines and then where the map is least certain, `viewpoints` goes
        from one landmark that is not yet accurate to the next.
    step_m
        Longest way between two decisions.
    accurate_sd_m
        A landmark is accurately estimated when its standard deviation is at most this.
    attempts
        Measurements after which a landmark that is still not accurate is given up.
    capacity
        Landmarks in one packet to teammates.
    surfacing
        Come up for a position fix when the time that this takes is worth it; else only at the end.
    stays_down
        Vehicles that never come up for a fix, be it for ice, hulls or nets above them: teammates' ranges must do.
    ranging
        Mend the position by the distance to teammates that every packet of theirs tells, and surface the later for it.
    """

    planner: MapPlannerName = "survey"
    step_m: Annotated[float, Meta(ge=0.5, le=1e6)] = 20.0
    accurate_sd_m: Annotated[float, Meta(ge=0.001, le=100)] = 0.1
    attempts: Annotated[int, Meta(ge=1, le=10_000)] = 200
    capacity: Annotated[int, Meta(ge=1, le=4_000)] = 10
    surfacing: bool = True
    stays_down: Annotated[tuple[str, ...], Meta(max_length=200)] = ()
    ranging: bool = True


Task = ExploreTask | CoverTask | MapTask
