"""Messages to bytes and back. Wrong bytes give None and are counted; they never raise and change nothing."""

from __future__ import annotations

from dataclasses import dataclass, field

import msgspec

from vehicle_agent.wire.messages import AnyMessage

MAX_MESSAGE_BYTES = 2_100_000


@dataclass(slots=True)
class Codec:
    """Encodes and decodes messages as tagged msgpack arrays.

    Attributes
    ----------
    dropped
        Byte strings refused so far.
    """

    dropped: int = 0
    _encoder: msgspec.msgpack.Encoder = field(default_factory=msgspec.msgpack.Encoder, repr=False)
    _decoder: msgspec.msgpack.Decoder[AnyMessage] = field(
        default_factory=lambda: msgspec.msgpack.Decoder(AnyMessage), repr=False
    )

    def encode(self, message: AnyMessage) -> bytes:
        return self._encoder.encode(message)

    def decode(self, data: bytes) -> AnyMessage | None:
        """Return the message, or None (counted in `dropped`) when the bytes are not one of ours."""
        if len(data) <= MAX_MESSAGE_BYTES:
            try:
                return self._decoder.decode(data)
            except (msgspec.DecodeError, RecursionError, UnicodeDecodeError):
                pass
        self.dropped += 1
        return None
