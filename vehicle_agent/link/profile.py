"""How a participant's Zenoh session is set up: a plain dictionary in, a Zenoh configuration out."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import zenoh

LEASE_MS = 3_000
"""A partition or a frozen peer is noticed after this; outages of two seconds pass unnoticed."""
KEEP_ALIVES_PER_LEASE = 4
RETRY_FIRST_MS = 250
RETRY_LONGEST_MS = 1_000


def session_profile(
    listen: Sequence[str], connect: Sequence[str], tls: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Settings of a peer that meets exactly the endpoints it is given.

    Nobody is scouted and nobody relays. An endpoint that cannot be listened on is an error at once; one that cannot be
    reached is tried again for ever in the background, so that the order in which a fleet starts does not matter.

    Parameters
    ----------
    listen, connect
        Zenoh endpoints, e.g. `tcp/127.0.0.1:7451`.
    tls
        Zenoh's `transport/link/tls`, for endpoints like `tls/127.0.0.1:7451`.
    """
    secured = {"tls": dict(tls)} if tls else {}
    return {
        "mode": "peer",
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}, "delay": 0},
        "listen": {"endpoints": list(listen), "timeout_ms": 0, "exit_on_failure": True},
        "connect": {
            "endpoints": list(connect),
            "timeout_ms": -1,
            "exit_on_failure": False,
            "retry": {
                "period_init_ms": RETRY_FIRST_MS,
                "period_max_ms": RETRY_LONGEST_MS,
                "period_increase_factor": 2.0,
            },
        },
        # Advanced publishers number their samples by time stamp and ask for this.
        "timestamping": {"enabled": True},
        "open": {"return_conditions": {"connect_scouted": False, "declares": False}},
        "transport": {
            "link": {
                **secured,
                "tx": {
                    "lease": LEASE_MS,
                    "keep_alive": KEEP_ALIVES_PER_LEASE,
                    # A frozen peer may stall the bulk sender this long before its transport is dropped.
                    "queue": {"congestion_control": {"block": {"wait_before_close": 2_000_000}}},
                },
            },
            # Bytes go over the link that is declared and counted, also on one machine.
            "shared_memory": {"enabled": False},
        },
    }


def zenoh_config(profile: Mapping[str, Any]) -> zenoh.Config:
    """Turn a profile into Zenoh's own configuration; raises zenoh.ZError on a malformed endpoint."""
    config = zenoh.Config()
    for path, value in _leaves("", profile):
        config.insert_json5(path, json.dumps(value))
    return config


def _leaves(prefix: str, table: Mapping[str, Any]) -> list[tuple[str, Any]]:
    leaves: list[tuple[str, Any]] = []
    for name, value in table.items():
        path = f"{prefix}/{name}" if prefix else name
        if isinstance(value, Mapping) and "endpoints" not in value and name != "retry":
            leaves += _leaves(path, value)
        else:
            leaves.append((path, value))
    return leaves
