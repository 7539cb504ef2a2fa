"""A mission file damaged in any way is a flyable mission or one sentence, never another exception."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

from vehicle_agent.mission.load import MissionError, load_mission

RIDGE = Path(__file__).parents[2] / "missions" / "ridge.toml"
VALUES = (
    "nan", "-inf", "-1", "0", "1e308", "1e-320", "9223372036854775808", "true", "2026-01-01", "07:30:00",
    "[]", "[[1]]", "{}", '""', '"x"', '"\\u0000"', '"\\n"', "''",
)  # fmt: skip
VALUE = re.compile(r"-?\d+\.?\d*|\"[^\"]*\"")


def refusal(file: Path) -> str | None:
    """Why a file is refused; None when it flies."""
    try:
        load_mission(file)
    except MissionError as error:
        return str(error)
    return None


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", range(4))
def test_damaged_files(tmp_path: Path, seed: int) -> None:
    dice = random.Random(seed)
    original = RIDGE.read_text(encoding="utf-8").replace("cell_m = 20.0", "cell_m = 100.0")
    file = tmp_path / "m.toml"
    refused = 0
    for _ in range(250):
        text = original
        for _ in range(dice.randint(0, 2)):
            place = dice.choice(list(VALUE.finditer(text)))
            text = text[: place.start()] + dice.choice(VALUES) + text[place.end() :]
        content = bytearray(text.encode())
        for _ in range(dice.choice((0, 0, 1, 3))):
            content[dice.randrange(len(content))] = dice.randrange(256)
        file.write_bytes(content)
        if (sentence := refusal(file)) is not None:
            refused += 1
            assert sentence.startswith(str(file))
            assert sentence.isprintable()
    assert 100 < refused < 250
