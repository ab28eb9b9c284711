"""Whatever a file holds, reading it ends in a result or in an error that a user can act on."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pyarrow import parquet
from scipy import io as scipy_io

from inertialcal.campaign.start.info import info as survey
from inertialcal.core.errors import InertialcalError
from inertialcal.files import read, read_table

QUICK = settings(max_examples=150, deadline=10_000, suppress_health_check=[HealthCheck.function_scoped_fixture])
SEEDS = (
    b"t_s,gyro_x [deg/s],acc_x,label\n0.0,1.5,9.8,a\n0.01,1.6,9.7,a\n0.02,-1.5e-3,9.9,b\n0.03,1.1,9.8,b\n",
    b"# rate 100 Hz\n%time;x;y\n0,0;1,5;2\n0,1;1,6;2\n0,2;1,7;3\n0,3;1,4;NaN\n",
    b"unix,x,y\n1283358139,1,2\n1283358141,3,\n1283358143,4,5\n1283358145,4,6\n",
    b"when\tx\n2010-09-01T16:22:19Z\t1\n2010-09-01T16:22:20Z\t2\n2010-09-01T16:22:21Z\t3\n",
    b"  0.5   33108 33329\n  0.6   33096 33336\n 0.7   33104 33333\n",
    b'"rate [deg/s]","x, dps"\r\n"-5",-5.01\r\n"5",5.02\r\n',
)
PIECES = (
    b"\n", b"\r", b",", b";", b"\t", b" ", b'"', b"#", b"%", b"//", b"\x00", b"\x1a", b"\xff\xfe", b"\xef\xbb\xbf",
    b"nan", b"inf", b"-", b"+", b"e", b"1e999", b"9" * 30, b"9" * 5000, b"12833581390", b"0x1F", b"1_0", b"1,5", b".",
    b"2010-02-30T00:00:00Z", b"[", b"](", b"()", b"[deg/s]", b"time", b"\xc2\xb0", b"\xb0", b"\xe2\x80\xa8", b"=1+1",
)  # fmt: skip


def opens_or_says_why(path: Path) -> None:
    for use in (read, read_table, survey):
        try:
            found = use(path)
        except InertialcalError as error:
            json.dumps([problem.to_dict() for problem in error.problems])
            continue
        if use is survey:
            json.dumps(found.to_dict(), allow_nan=False)  # type: ignore[union-attr]


@QUICK
@given(data=st.binary(max_size=400))
def test_random_bytes(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(data)
    opens_or_says_why(path)


@QUICK
@given(text=st.text(st.sampled_from('0123456789.,;-+e \t\n\r"#%nat[]()xyz_:TZ/'), max_size=300))
def test_random_tables(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8", newline="")
    opens_or_says_why(path)


def mutate(content: bytes, choice: random.Random) -> bytes:
    """Change a few places: a piece in, a stretch out or twice, a byte changed."""
    for _ in range(choice.randint(1, 4)):
        at = choice.randrange(len(content) + 1)
        to = min(len(content), at + choice.randint(0, 12))
        match choice.randrange(4):
            case 0:
                content = content[:at] + choice.choice(PIECES) + content[at:]
            case 1:
                content = content[:at] + content[to:]
            case 2:
                content = content[:to] + content[at:to] * choice.randint(1, 5) + content[to:]
            case _:
                content = content[:at] + bytes([choice.randrange(256)]) + content[at + 1 :]
    return content


@settings(QUICK, max_examples=300)
@given(seed=st.sampled_from(SEEDS), choice=st.randoms(use_true_random=False))
def test_mutated_tables(tmp_path: Path, seed: bytes, choice: random.Random) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(mutate(seed, choice))
    opens_or_says_why(path)


@pytest.mark.slow
def test_two_thousand_mutated_tables(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    choice = random.Random(1)
    for _ in range(2000):
        path.write_bytes(mutate(choice.choice(SEEDS), choice))
        opens_or_says_why(path)


def _npz(path: Path) -> None:
    np.savez(path.with_suffix(".npz"), t=np.arange(9) / 7, x=np.arange(27).reshape(9, 3))
    path.with_suffix(".npz").rename(path)


BINARY: dict[str, Callable[[Path], object]] = {
    "mat5": lambda p: scipy_io.savemat(p, {"t": np.arange(9) / 7, "s": {"x": np.ones(9)}, "c": "text"}),
    "mat4": lambda p: scipy_io.savemat(p, {"t": np.arange(9) / 7, "x": np.ones(9)}, format="4"),
    "npz": _npz,
    "parquet": lambda p: parquet.write_table(pa.table({"t": np.arange(9) / 7, "x": list("abcdefghi")}), p),
}


@pytest.mark.parametrize("kind", BINARY)
def test_mutated_binary_files(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "a.mat"
    BINARY[kind](path)
    whole = path.read_bytes()
    choice = random.Random(kind)
    for _ in range(60):
        path.write_bytes(mutate(whole, choice))
        opens_or_says_why(path)
