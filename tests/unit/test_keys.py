"""Keys and the topic table."""

from __future__ import annotations

import typing

import pytest

from vehicle_agent.wire.keys import TOPIC_BY_MESSAGE, TOPICS, Delivery, alive_key, key, parse
from vehicle_agent.wire.messages import AnyMessage


def test_every_message_has_exactly_one_topic() -> None:
    assert set(TOPIC_BY_MESSAGE) == set(typing.get_args(AnyMessage))
    assert len(TOPICS) == len(TOPIC_BY_MESSAGE) == len({topic.name for topic in TOPICS})


def test_only_recovered_topics_keep_history() -> None:
    assert all((topic.history > 0) == (topic.delivery is Delivery.RECOVERED) for topic in TOPICS)


def test_a_fleets_ordinary_traffic_fits_two_kilobytes_a_second() -> None:
    periodic = [topic for topic in TOPICS if topic.period_s is not None and topic.over_radio]
    assert sum(topic.bytes_per_message / (topic.period_s or 1) for topic in periodic) <= 2_000


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: str(topic.name))
def test_keys_are_parsed_back(topic: typing.Any) -> None:
    assert parse(key("ridge", "merlin-2", topic)) == ("ridge", "merlin-2", topic.name)
    assert parse(key("ridge", "merlin-2", topic.name)) == ("ridge", "merlin-2", topic.name)


def test_liveliness_keys_are_parsed_back() -> None:
    assert parse(alive_key("ridge", "merlin")) == ("ridge", "merlin", "alive")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "fleet/ridge/v1/merlin",
        "fleet/ridge/v2/merlin/status",
        "fleet/ridge/v1/merlin/status/more",
        "herd/ridge/v1/merlin/status",
        "fleet/ridge/v1/merlin/gossip",
        "fleet/ridge/v1/*/status",
        "fleet/ridge/v1//status",
        "fleet/ridge/v1/Merlin/status",
        "fleet/../v1/merlin/status",
        "fleet/ridge/v1/merlin\n/status",
        f"fleet/ridge/v1/{'m' * 32}/status",
    ],
)
def test_foreign_keys_are_not_ours(text: str) -> None:
    assert parse(text) is None
