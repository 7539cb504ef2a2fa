"""The ways into the ground station that are decided before anything is drawn."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from ground_station import serve as serving
from ground_station.cli import main
from ground_station.serve import is_loopback


@pytest.mark.parametrize(
    ("host", "safe"),
    [
        ("127.0.0.1", True), ("localhost", True), ("::1", True), ("127.9.9.9", True),
        ("0.0.0.0", False), ("192.168.1.4", False), ("example.org", False), ("", False),
    ],
)  # fmt: skip
def test_only_loopback_counts_as_private(host: str, safe: bool) -> None:
    assert is_loopback(host) is safe


@pytest.mark.parametrize("arguments", [[], ["mission.toml", "--replay", "run"]])
def test_either_a_mission_or_a_recording_is_wanted(arguments: list[str]) -> None:
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 2
    assert "either a MISSION file or --replay RUN" in result.output


def test_a_missing_recording_is_refused_in_one_sentence(tmp_path: Path) -> None:
    result = CliRunner().invoke(main, ["--replay", str(tmp_path / "nowhere.mcap"), "--plain"])
    assert result.exit_code == 2
    assert result.output.count("\n") == 1
    assert "nowhere.mcap" in result.output


def test_served_dashboards_get_the_same_options_and_strangers_are_announced(monkeypatch: pytest.MonkeyPatch) -> None:
    served: list[tuple[list[str], str, int]] = []
    monkeypatch.setattr(serving, "serve", lambda words, host, port, title: served.append((words, host, port)))
    words = ["mission.toml", "--serve", "--ascii", "--port", "9000", "--host=0.0.0.0", "--theme", "day"]
    monkeypatch.setattr("sys.argv", ["ground-station", *words])
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 0
    assert served == [(["mission.toml", "--ascii", "--theme", "day"], "0.0.0.0", 9000)]
    assert "can command the fleet" in result.output
