"""Compiled kernels of the voxel map: rays through voxels, and what a scan adds to the evidence.

A scan is first drawn into a box of marks around the sensor, so that a voxel that thousands of rays cross counts once,
and a hit outweighs what crosses beside it; then the marks are folded into blocks of 8 x 8 x 8 voxels.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_evidence import HIT_STEP, MAX_HITS, MAX_MISSES, ByteArray

CountArray = npt.NDArray[np.uint16]

BLOCK = 8
"""Voxels along an edge of a block; a run of them along up is one 64-bit word of marks."""
BLOCK_VOXELS = BLOCK**3
FREE, HIT = 1, 2
RAY_END = 1 << 48
NEVER = 1 << 62
_ONES = np.uint64(0x0101010101010101)
_HITS = np.uint64(0x0202020202020202)
_MISSES = np.uint64(0x0707070707070707)
_UP_TO_EIGHT = np.uint64((8 - MAX_MISSES) * 0x0101010101010101)
_THREE = np.uint64(3)


@compiled
def _axis(start: float, stop: float, first: int, stride: int) -> tuple[int, int, int, int]:
    """Borders that a ray crosses on one axis; where it crosses the first; the way between two; the stride.

    Places on a ray count from 0 at the sensor to RAY_END: whole numbers compare and add faster than floats.
    """
    borders = abs(math.floor(stop) - first)
    if borders == 0:
        return 0, NEVER, 0, stride
    change = stop - start
    away = first + 1 - start if change > 0.0 else start - first
    between = min(1.0 / abs(change), 1000.0)  # beyond the ray's end all the same
    at = int(away / abs(change) * RAY_END)
    return borders, at, int(between * RAY_END), stride if change > 0.0 else -stride


@compiled
def draw_rays(
    marks: ByteArray, box: IndexArray, sensor: FloatArray, ends: FloatArray, returned: BoolArray, max_range: float
) -> None:
    """Mark voxels crossed by rays as FREE and voxels in which rays end as HIT (Amanatides and Woo 1987).

    Between two borders on the ray's longest axis it crosses at most one on each other axis: so the inner loop takes one
    slab after another and has no branch that a processor could guess wrong.

    Parameters
    ----------
    marks : (voxels of the box,) uint8 in C order, zero at first; `box` is (6,) its lowest voxel and its size.
    sensor : (3,) float64 and ends : (N, 3) float64, in voxels from the grid's corner.
    returned : (N,) bool; a ray that did not return leaves its last voxel FREE.
    max_range : voxels; a longer ray is cut there, and the voxel in which it is cut stays unmarked.
    """
    stride_u, stride_v = box[4] * box[5], box[5]
    su, sv, sw = sensor[0], sensor[1], sensor[2]
    u0, v0, w0 = math.floor(su), math.floor(sv), math.floor(sw)
    start = (u0 - box[0]) * stride_u + (v0 - box[1]) * stride_v + (w0 - box[2])
    last = np.full(len(ends), -1, dtype=np.int64)
    for ray in range(len(ends)):
        eu, ev, ew = ends[ray, 0], ends[ray, 1], ends[ray, 2]
        du, dv, dw = eu - su, ev - sv, ew - sw
        length = math.sqrt(du * du + dv * dv + dw * dw)
        cut = length > max_range
        if cut:
            part = max_range / length
            eu, ev, ew = su + du * part, sv + dv * part, sw + dw * part
        n0, t0, d0, s0 = _axis(su, eu, u0, stride_u)
        n1, t1, d1, s1 = _axis(sv, ev, v0, stride_v)
        n2, t2, d2, s2 = _axis(sw, ew, w0, 1)
        end = start + n0 * s0 + n1 * s1 + n2 * s2
        if abs(dv) > abs(du) and abs(dv) >= abs(dw):
            n0, t0, d0, s0, n1, t1, d1, s1 = n1, t1, d1, s1, n0, t0, d0, s0
        elif abs(dw) > abs(du):
            n0, t0, d0, s0, n2, t2, d2, s2 = n2, t2, d2, s2, n0, t0, d0, s0
        place, left1, left2 = start, n1, n2
        border = t0
        for _ in range(n0):
            marks[np.uint64(place)] = FREE
            cross1, cross2 = -int(t1 < border), -int(t2 < border)  # all bits or none
            first1 = -int(t1 < t2)
            only1, only2 = cross1 & (first1 | ~cross2), cross2 & (~first1 | ~cross1)
            marks[np.uint64(place + (only1 & s1) + (only2 & s2))] = FREE
            place += (cross1 & s1) + (cross2 & s2)
            marks[np.uint64(place)] = FREE
            t1 += cross1 & d1
            t2 += cross2 & d2
            left1 += cross1
            left2 += cross2
            place += s0
            border += d0
        while left1 > 0 or left2 > 0:
            marks[place] = FREE
            if left1 > 0 and (left2 <= 0 or t1 < t2):
                place, left1, t1 = place + s1, left1 - 1, t1 + d1
            else:
                place, left2, t2 = place + s2, left2 - 1, t2 + d2
        if not cut:
            if returned[ray]:
                last[ray] = end
            else:
                marks[end] = FREE
    for ray in range(len(ends)):
        if last[ray] >= 0:
            marks[last[ray]] = HIT


@compiled
def blocks_in_box(marks: ByteArray, box: IndexArray, blocks: IndexArray) -> BoolArray:
    """Which blocks of the grid hold a mark: (block columns x rows x layers,) bool; the box is aligned to blocks.

    `blocks` is (3,) the grid's size in blocks; blocks outside it are left out.
    """
    words = marks.view(np.uint64)
    touched = np.zeros(blocks[0] * blocks[1] * blocks[2], dtype=np.bool_)
    runs = box[5] // BLOCK
    for u in range(box[3]):
        block_u = (box[0] + u) // BLOCK
        if not 0 <= block_u < blocks[0]:
            continue
        for v in range(box[4]):
            block_v = (box[1] + v) // BLOCK
            if not 0 <= block_v < blocks[1]:
                continue
            first = (u * box[4] + v) * runs
            for run in range(runs):
                if words[first + run] != 0:
                    block_w = box[2] // BLOCK + run
                    if 0 <= block_w < blocks[2]:
                        touched[(block_u * blocks[1] + block_v) * blocks[2] + block_w] = True
    return touched


@compiled
def fold_marks(
    marks: ByteArray, box: IndexArray, shape: IndexArray, slots: npt.NDArray[np.int32], blocks: IndexArray,
    evidence: ByteArray, untold: ByteArray, max_hits: int,
) -> tuple[IndexArray, int]:  # fmt: skip
    """Add a scan's marks to one contributor's evidence, and clear them.

    Parameters
    ----------
    shape : (3,) the grid's size in voxels; slots : block -> slot or -1; blocks : (3,) the grid's size in blocks.
    evidence, untold : (slots, BLOCK_VOXELS) uint8; `untold` becomes 1 where the evidence grew.
    max_hits : the box holds no more HITs than this.

    Returns
    -------
    flat indices (not sorted) of the voxels that were hit, and how many marked voxels had no slot.
    """
    words = marks.view(np.uint64)
    evidence_words, untold_words = evidence.reshape(-1).view(np.uint64), untold.reshape(-1).view(np.uint64)
    runs = box[5] // BLOCK
    hits = np.empty(max_hits, dtype=np.int64)
    count, lost = 0, 0
    for u in range(box[3]):
        column = box[0] + u
        inside_u = 0 <= column < shape[0]
        for v in range(box[4]):
            row = box[1] + v
            inside = inside_u and 0 <= row < shape[1]
            first = (u * box[4] + v) * runs
            for run in range(runs):
                if words[first + run] == 0:
                    continue
                block_w = box[2] // BLOCK + run
                place = (first + run) * BLOCK
                if not inside or block_w < 0 or block_w >= blocks[2]:
                    words[first + run] = 0
                    continue
                slot = slots[((column // BLOCK) * blocks[1] + row // BLOCK) * blocks[2] + block_w]
                base = ((column % BLOCK) * BLOCK + row % BLOCK) * BLOCK
                layer = block_w * BLOCK
                word = (slot * BLOCK_VOXELS + base) // BLOCK
                if slot >= 0 and layer + BLOCK <= shape[2] and words[first + run] & _HITS == 0:
                    # Eight bytes at once: one more miss wherever there are fewer than MAX_MISSES.
                    full = ((evidence_words[word] & _MISSES) + _UP_TO_EIGHT) >> _THREE & _ONES
                    grown_by = words[first + run] & ~full
                    evidence_words[word] += grown_by
                    untold_words[word] |= grown_by
                    words[first + run] = 0
                    continue
                for w in range(min(BLOCK, shape[2] - layer)):
                    mark = marks[place + w]
                    if mark == 0:
                        continue
                    if slot < 0:
                        lost += 1
                        continue
                    value = evidence[slot, base + w]
                    if mark == FREE:
                        if value % HIT_STEP < MAX_MISSES:
                            evidence[slot, base + w] = value + 1
                            untold[slot, base + w] = 1
                    else:
                        if value // HIT_STEP < MAX_HITS:
                            evidence[slot, base + w] = value + HIT_STEP
                            untold[slot, base + w] = 1
                        hits[count] = (column * shape[1] + row) * shape[2] + layer + w
                        count += 1
                words[first + run] = 0
    return hits[:count].copy(), lost


@compiled
def fold_stamps(
    voxels: IndexArray, stamps_ms: IndexArray, bits: npt.NDArray[np.uint64], shape: IndexArray, blocks: IndexArray,
    slots: npt.NDArray[np.int32], surface_slots: npt.NDArray[np.int32],
    first_stamps_ms: IndexArray, observers: npt.NDArray[np.uint64],
) -> BoolArray:  # fmt: skip
    """Keep the earlier observation of each surface voxel; of two at one instant both observers (Renzaglia eq. 4).

    Returns
    -------
    (N,) bool, which voxels changed; voxels without a slot do not.
    """
    changed = np.zeros(len(voxels), dtype=np.bool_)
    for index in range(len(voxels)):
        slot, local = slot_of(voxels[index], shape, blocks, slots)
        surface = surface_slots[slot] if slot >= 0 else -1
        if surface < 0:
            continue
        stamp = stamps_ms[index]
        if stamp < first_stamps_ms[surface, local]:
            first_stamps_ms[surface, local] = stamp
            observers[surface, local] = bits[index]
            changed[index] = True
        elif stamp == first_stamps_ms[surface, local]:
            joined = observers[surface, local] | bits[index]
            changed[index] = joined != observers[surface, local]
            observers[surface, local] = joined
    return changed


@compiled
def slot_of(voxel: int, shape: IndexArray, blocks: IndexArray, slots: npt.NDArray[np.int32]) -> tuple[int, int]:
    """Slot of a voxel's block (-1 when it has none) and the voxel's place in the block."""
    layer = voxel % shape[2]
    row = voxel // shape[2] % shape[1]
    column = voxel // shape[2] // shape[1]
    block = ((column // BLOCK) * blocks[1] + row // BLOCK) * blocks[2] + layer // BLOCK
    return slots[block], ((column % BLOCK) * BLOCK + row % BLOCK) * BLOCK + layer % BLOCK


@compiled
def slots_with(
    voxels: IndexArray, shape: IndexArray, blocks: IndexArray, slots: npt.NDArray[np.int32], count: int
) -> BoolArray:
    """Which of `count` slots hold one of the voxels: (count,) bool."""
    holds = np.zeros(count, dtype=np.bool_)
    for voxel in voxels:
        slot, _ = slot_of(voxel, shape, blocks, slots)
        if slot >= 0:
            holds[slot] = True
    return holds


@compiled
def voxels_of_block(block: int, shape: IndexArray, blocks: IndexArray) -> IndexArray:
    """Flat indices of a block's voxels in its own order: (BLOCK_VOXELS,) int64, -1 for those outside the grid."""
    voxels = np.full(BLOCK_VOXELS, -1, dtype=np.int64)
    low_w = block % blocks[2] * BLOCK
    low_v = block // blocks[2] % blocks[1] * BLOCK
    low_u = block // blocks[2] // blocks[1] * BLOCK
    for u in range(min(BLOCK, shape[0] - low_u)):
        for v in range(min(BLOCK, shape[1] - low_v)):
            for w in range(min(BLOCK, shape[2] - low_w)):
                flat = ((low_u + u) * shape[1] + low_v + v) * shape[2] + low_w + w
                voxels[(u * BLOCK + v) * BLOCK + w] = flat
    return voxels


@compiled
def add_evidence(
    hits: CountArray, misses: CountArray, block_ids: IndexArray, evidence: ByteArray, shape: IndexArray,
    blocks: IndexArray,
) -> None:  # fmt: skip
    """Add one contributor's evidence to dense counts by flat index: (voxels,) uint16 each.

    `block_ids` is the block in each slot.
    """
    for slot in range(min(len(block_ids), len(evidence))):
        voxels = voxels_of_block(block_ids[slot], shape, blocks)
        for local in range(BLOCK_VOXELS):
            value = evidence[slot, local]
            if value != 0 and voxels[local] >= 0:
                misses[voxels[local]] += value % HIT_STEP
                hits[voxels[local]] += value // HIT_STEP
