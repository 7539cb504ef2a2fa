"""What all tables of a mission file are made of."""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta

LINE_PATTERN = r"^[^\x00-\x1f\x7f-\x9f\u2028\u2029]*\Z"
Positive = Annotated[float, Meta(ge=0.001, le=1e6)]
NonNegative = Annotated[float, Meta(ge=0, le=1e6)]
Metres = Annotated[float, Meta(ge=-1e6, le=1e6)]
AltitudeM = Annotated[float, Meta(ge=-12_000, le=12_000)]


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of the mission file: unknown keys are errors."""
