"""What a link has carried and what it has lost."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class LinkCounters:
    """Counts since the link was opened; bytes are payload and key of topics that go over the radio.

    Attributes
    ----------
    bytes_sent, messages_sent
        Handed to Zenoh.
    bytes_received, messages_received
        Delivered by Zenoh and decoded.
    undecodable
        Arrived, but were not a message that belongs on their key.
    overflowed
        Arrived, but were pushed out of the receiving queue before anybody took them.
    paced_out
        Bulk messages pushed out of the sending queue because the declared rate was too low for them.
    send_failures
        Refused by Zenoh, e.g. because the link is closed.
    """

    bytes_sent: int = 0
    messages_sent: int = 0
    bytes_received: int = 0
    messages_received: int = 0
    undecodable: int = 0
    overflowed: int = 0
    paced_out: int = 0
    send_failures: int = 0

    @property
    def dropped(self) -> int:
        """Messages that were lost at this end."""
        return self.undecodable + self.overflowed + self.paced_out + self.send_failures
