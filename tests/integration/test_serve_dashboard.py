"""The dashboard in a browser: a page, and a dashboard process per visitor behind a web socket."""

from __future__ import annotations

import asyncio
import json
import signal
import socket
import sys
import time
from pathlib import Path

import aiohttp
import pytest

from ground_station.recording import FILE_NAME, RecordingWriter
from ground_station.station import Station
from tests.fakes.talking_fleet import NAMES, ListLink, Voice, small_plan

LIMIT_S = 60.0


def record(folder: Path) -> None:
    station = Station(small_plan(), "station-0001", 9, 0.0, recording=RecordingWriter(folder / FILE_NAME))
    link = ListLink()
    station.attach(link)
    voices = [Voice(name) for name in NAMES]
    for second in range(20):
        link.arriving += [voice.status(second) for voice in voices]
        station.step(float(second))
    station.close()


async def first_page(visitor: aiohttp.ClientSession, address: str) -> str:
    """What a server says at an address once it is there."""
    deadline_s = time.monotonic() + LIMIT_S
    while True:
        try:
            async with visitor.get(address) as page:
                assert page.status == 200
                return await page.text()
        except aiohttp.ClientConnectorError:
            assert time.monotonic() < deadline_s
            await asyncio.sleep(0.05)


@pytest.mark.processes
async def test_a_visitor_sees_the_dashboard(tmp_path: Path) -> None:
    record(tmp_path)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    words = ["-m", "ground_station.cli", "--replay", str(tmp_path), "--serve", "--port", str(port)]
    process = await asyncio.create_subprocess_exec(
        sys.executable, *words, stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.DEVNULL
    )
    try:
        async with aiohttp.ClientSession() as visitor:
            assert "ground station" in await first_page(visitor, f"http://127.0.0.1:{port}/")
            drawn = b""
            async with visitor.ws_connect(f"ws://127.0.0.1:{port}/ws?width=80&height=24") as line:
                while b"merlin" not in drawn:
                    message = await line.receive(timeout=LIMIT_S)
                    assert message.type in (aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY)
                    if message.type is aiohttp.WSMsgType.BINARY:
                        drawn += message.data
                await line.send_str(json.dumps(["stdin", "q"]))
                while b"Leave the ground station" not in drawn:
                    message = await line.receive(timeout=LIMIT_S)
                    assert message.type in (aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY)
                    if message.type is aiohttp.WSMsgType.BINARY:
                        drawn += message.data
    finally:
        process.send_signal(signal.SIGINT)
        try:
            await asyncio.wait_for(process.wait(), 10.0)
        except TimeoutError:
            process.kill()
