"""Mutual TLS on the fleet link: who has the fleet's certificate is heard, and a refusal is a sentence."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from click.testing import CliRunner

from ground_station.cli import main
from ground_station.link import open_link
from missions.bench.detection import free_ports
from missions.bench.talking_fleet import TalkingLink, mission_text
from tests.fakes.waiting import until
from vehicle_agent.link.session import FleetLink, LinkError
from vehicle_agent.link.tls import TlsFiles, refusal
from vehicle_agent.mission.load import MissionPlan, load_mission
from vehicle_agent.wire.messages import Status

pytestmark = pytest.mark.skipif(shutil.which("openssl") is None, reason="needs the openssl program")


def openssl(folder: Path, *arguments: str) -> None:
    subprocess.run(["openssl", *arguments], cwd=folder, check=True, capture_output=True)


def authority(folder: Path, *participants: str) -> None:
    """An authority's certificate, and one for each participant, signed by it."""
    folder.mkdir(exist_ok=True)
    new_key = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")
    openssl(folder, "req", "-x509", *new_key, "-keyout", "ca.key", "-out", "ca.pem", "-days", "2", "-subj", "/CN=fleet",
            "-addext", "basicConstraints=critical,CA:TRUE")  # fmt: skip
    (folder / "leaf.cnf").write_text("subjectAltName=IP:127.0.0.1\nbasicConstraints=CA:FALSE\n")
    for name in participants:
        openssl(folder, "req", *new_key, "-keyout", f"{name}.key", "-out", f"{name}.csr", "-subj", f"/CN={name}")
        openssl(folder, "x509", "-req", "-in", f"{name}.csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial",
                "-days", "2", "-extfile", "leaf.cnf", "-out", f"{name}.pem")  # fmt: skip


@pytest.fixture
def plan(tmp_path: Path) -> MissionPlan:
    """A mission whose fleet has certificates, and strangers' certificates beside them."""
    authority(tmp_path / "certificates", "vehicle-1", "station")
    authority(tmp_path / "strangers", "station")
    text = mission_text(1, free_ports(2)).replace("radio = {", "radio = { tls = {},")
    (tmp_path / "mission.toml").write_text(text)
    return load_mission(tmp_path / "mission.toml")


@pytest.fixture
def agent(plan: MissionPlan):  # type: ignore[no-untyped-def]
    tls = TlsFiles.of(plan.tls_paths("vehicle-1"))
    link = FleetLink.open(plan.mission.name, "vehicle-1", listen=[plan.agent_endpoint(0)], tls=tls)
    yield link
    link.close()


def test_a_station_of_the_fleet_hears_the_vehicle(plan: MissionPlan, agent: FleetLink) -> None:
    station = open_link(plan, "station-0001")
    voice, heard = TalkingLink(plan), list[Status]()

    def is_heard() -> bool:
        for message in voice.say(0, 1):
            agent.publish(message)
        heard.extend(message for message in station.poll() if isinstance(message, Status))
        return bool(heard)

    until(is_heard, "the vehicle's status")
    station.close()
    assert {message.sender for message in heard} == {"vehicle-1"}


def test_a_strangers_certificate_is_refused_in_plain_words(plan: MissionPlan, agent: FleetLink) -> None:
    folder = plan.source.parent
    for name in ("station.pem", "station.key"):
        shutil.copy(folder / "strangers" / name, folder / "certificates" / name)
    with pytest.raises(LinkError, match=r"refuses the certificate .*station.pem.*have that certificate signed"):
        open_link(plan, "station-0001")
    result = CliRunner().invoke(main, [str(plan.source), "--plain"])
    assert result.exit_code == 2
    assert "refuses the certificate" in result.output
    assert "Timeout" not in result.output


def test_a_vehicle_of_another_authority_is_refused_here(plan: MissionPlan, agent: FleetLink) -> None:
    strangers = plan.source.parent / "strangers"
    files = TlsFiles(strangers / "ca.pem", strangers / "station.pem", strangers / "station.key")
    sentence = refusal(plan.agent_endpoint(0), files)
    assert sentence is not None
    assert "its certificate is refused here" in sentence
    assert str(strangers / "ca.pem") in sentence


def test_a_vehicle_that_is_not_there_yet_is_no_refusal(plan: MissionPlan) -> None:
    station = open_link(plan, "station-0001")
    assert isinstance(station, FleetLink)
    assert station.connected_peers() == 0
    station.close()


def test_a_missing_or_wrong_file_is_named_with_its_key(plan: MissionPlan) -> None:
    folder = plan.source.parent / "certificates"
    (folder / "station.key").write_text("not a key")
    with pytest.raises(LinkError, match=r"station.pem: is no PEM certificate that fits the key .*station.key"):
        open_link(plan, "station-0001")
    (folder / "ca.pem").unlink()
    with pytest.raises(LinkError, match=r"ca.pem: no such file or directory; correct radio.tls.ca"):
        open_link(plan, "station-0001")
