"""Range images survive the wire to a part of their range, and forged ones are refused without raising."""

from __future__ import annotations

import zlib

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from vehicle_agent.domain.range_image import RangeImage
from vehicle_agent.wire.range_blob import pack_ranges, unpack_ranges

RAYS = 40
places = st.tuples(*[st.floats(-1e5, 1e5)] * 3)
images = st.builds(
    RangeImage,
    places,
    arrays.arrays(np.float32, RAYS, elements=st.floats(0.0, 60.0, width=32)),
    arrays.arrays(np.bool_, RAYS),
    st.integers(0, 2**53),
)


@settings(deadline=None)
@given(images)
def test_what_is_packed_comes_back(image: RangeImage) -> None:
    heard = unpack_ranges(pack_ranges(image), RAYS)
    assert heard is not None
    assert (heard.sensor_enu_m, heard.stamp_ms) == (image.sensor_enu_m, image.stamp_ms)
    assert np.array_equal(heard.returned, image.returned)
    assert np.abs(heard.ranges_m - image.ranges_m).max() <= image.ranges_m.max() / 32_767 + 1e-5
    assert unpack_ranges(pack_ranges(image), RAYS + 1) is None


@settings(deadline=None)
@given(st.binary(max_size=200) | st.binary(max_size=200).map(zlib.compress))
def test_noise_is_refused(noise: bytes) -> None:
    assert unpack_ranges(noise, RAYS) is None


@settings(deadline=None)
@given(images, st.data())
def test_a_forged_byte_is_refused_or_harmless(image: RangeImage, data: st.DataObject) -> None:
    raw = bytearray(zlib.decompress(pack_ranges(image)))
    raw[data.draw(st.integers(0, len(raw) - 1))] = data.draw(st.integers(0, 255))
    heard = unpack_ranges(zlib.compress(bytes(raw)), RAYS)
    if heard is not None:
        assert np.isfinite(heard.ranges_m).all()
        assert np.isfinite(heard.sensor_enu_m).all()
