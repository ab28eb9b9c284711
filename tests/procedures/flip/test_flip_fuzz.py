"""600 mutated campaign files, tables, records and headers of flips: refused or reduced, never a traceback."""

from __future__ import annotations

import json
import random
import re
import shutil
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from inertialcal import flip
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.example import copy_example
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.core.errors import InertialcalError
from inertialcal.core.schema.json_text import json_text
from inertialcal.rigs.sams_tsh.campaign import FILE
from inertialcal.rigs.sams_tsh.rig import Bench, build
from inertialcal.rigs.twin import SEED
from pad_pairs_made import BENCH, flip_records
from sized import sized

SHORT = replace(Bench(), rate=1.0, duration=1800.0, turn_starts=(600.0, 1200.0), window=120.0, settle=5.0)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
NUMBERS = ("0", "", "nan", "inf", "1e300", "-1e300", "1e-300", "-1", "999999", "7")
PIECES = (
    "nan", "1e999", "-1", '""', "[]", "{}", "true", "\n", ",", ";", '"', "\x00", "9" * 400, "=", "[[tests]]\n",
    '"1 deg"', "1979-05-27", "null", "\ufeff", "../", "%s", "0x7fffffffffffffffffff", "deg", "180 deg", "ug", "1e300",
    "x", "2014-10-22T09:36:36Z", "006/00:56:24", "count", "<", ">", "&",
)  # fmt: skip
KINDS = 5


def mutated(text: str, choice: random.Random) -> str:
    """Change numbers alone, or put pieces in the place of others."""
    for _ in range(choice.randint(1, 3)):
        found = list(NUMBER.finditer(text))
        if found and choice.random() < 0.6:
            one = choice.choice(found)
            value = float(one[0])
            new = choice.choice((*NUMBERS, str(-value), str(value * 1e3), str(value * 1e-6), str(value + 1.0)))
            text = text[: one.start()] + new + text[one.end() :]
        else:
            at = choice.randrange(len(text) + 1)
            text = text[:at] + choice.choice(PIECES) + text[at + choice.choice((0, 0, 1, 5, 25)) :]
    return text


def survives(use: Callable[[], Any]) -> bool:
    """Whether something came out; what is refused says why."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            json_text(use())
        except InertialcalError as error:
            json.dumps([problem.to_dict() for problem in error.problems])
            assert all(problem.what for problem in error.problems)  # noqa: PT017
            return False
    return True


def mutate_some(root: Path, count: int, seed: int) -> int:
    """Return how many of the mutated inputs still gave results."""
    means = copy_example("sams1996", root / "means")
    rig, archive = root / "rig", flip_records(root / "archive", files=1, bench=BENCH)
    (rig / FILE).parent.mkdir(parents=True)
    twin = build(SHORT, 3)
    (rig / "campaign.toml").write_text(twin.campaign.replace(SEED, "3"), encoding="utf-8")
    (rig / FILE).write_text(csv_text(twin.recordings[FILE]), encoding="utf-8")
    (header,) = archive.glob("*.header")
    ways: list[tuple[Path, Callable[[], Any]]] = [
        (means / "campaign.toml", lambda: run(means, write=False).results),
        (means / "table03_semiprocessed.csv", lambda: run(means, write=False).results),
        (rig / "campaign.toml", lambda: run(rig, write=False).results),
        (rig / FILE, lambda: run(rig, write=False).results),
        (header, lambda: [row.to_dict() for row in flip(archive).rows]),
    ]
    whole = {path: path.read_text(encoding="utf-8") for path, _ in ways}
    for path, use in ways:
        assert survives(use), path
    choice, left = random.Random(seed), 0
    for number in range(count):
        path, use = ways[number % KINDS]
        path.write_text(mutated(whole[path], choice), encoding="utf-8", errors="surrogatepass")
        left += survives(use)
        path.write_text(whole[path], encoding="utf-8")
    shutil.rmtree(root)
    return left


def test_mutated_inputs(tmp_path: Path) -> None:
    assert 0 < mutate_some(tmp_path / "some", 40, 1) < 40


@pytest.mark.slow
def test_many_mutated_inputs(tmp_path: Path) -> None:
    n = sized(600, 150)
    assert 0 < mutate_some(tmp_path / "many", n, 2) < n


@pytest.mark.parametrize("change", [b"\x00", b"\xff", b"\x7f"])
def test_bytes_of_an_archive_record(tmp_path: Path, change: bytes) -> None:
    folder = flip_records(tmp_path, files=1)
    (data,) = folder.glob("*.121f03")
    whole = bytearray(data.read_bytes())
    choice = random.Random(3)
    for _ in range(10):
        at = choice.randrange(len(whole) - 40)
        length = choice.randint(1, 40)
        data.write_bytes(bytes(whole[:at] + change * length + whole[at + length :]))
        survives(lambda: [row.to_dict() for row in flip(folder).rows])
