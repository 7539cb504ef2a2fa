"""Which numbers of a counted series were seen: compact, immutable, bounded."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

MAX_RANGES = 512


@dataclass(frozen=True, slots=True)
class SequenceRanges:
    """A set of non-negative integers as sorted, disjoint, non-touching half-open ranges.

    With more than `MAX_RANGES` ranges the two lowest are joined: numbers lost long ago then count as seen.

    Attributes
    ----------
    ranges
        (start, stop) pairs.
    """

    ranges: tuple[tuple[int, int], ...] = ()

    def __contains__(self, number: int) -> bool:
        at = bisect_right(self.ranges, number, key=lambda one: one[0])
        return at > 0 and number < self.ranges[at - 1][1]

    def with_number(self, number: int) -> SequenceRanges:
        """The set with one more number; itself when it was there."""
        ranges = self.ranges
        at = bisect_right(ranges, number, key=lambda one: one[0])
        if at > 0 and number < ranges[at - 1][1]:
            return self
        start, stop, low, high = number, number + 1, at, at
        if at > 0 and ranges[at - 1][1] == number:
            start, low = ranges[at - 1][0], at - 1
        if at < len(ranges) and ranges[at][0] == number + 1:
            stop, high = ranges[at][1], at + 1
        joined = (*ranges[:low], (start, stop), *ranges[high:])
        if len(joined) > MAX_RANGES:
            joined = ((joined[0][0], joined[1][1]), *joined[2:])
        return SequenceRanges(joined)

    @property
    def contiguous(self) -> int:
        """How many numbers from 0 on are seen without a gap."""
        return self.ranges[0][1] if self.ranges and self.ranges[0][0] == 0 else 0
