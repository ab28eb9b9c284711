"""The process of a command: real signals, streams that are closed, full or narrow, encodings, names of any bytes."""

from __future__ import annotations

import ast
import codecs
import fcntl
import json
import os
import pty
import re
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pytest

import inertialcal
from inertialcal.campaign.file.example import copy_example
from inertialcal.cli.encoding import ASCII, NEAREST, nearest

SOURCE = Path(inertialcal.__file__).parent
slow = pytest.mark.slow  # the default suite has one of each kind
COMMAND = [sys.executable, "-m", "inertialcal"]


@pytest.fixture(scope="module", name="campaign")
def _campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A published campaign, which ends as INCONCLUSIVE."""
    return copy_example("reinel1969", tmp_path_factory.mktemp("process") / "campaign")


@pytest.fixture(scope="module", name="table")
def _table(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """A quick command that prints results with signs beyond ASCII."""
    path = str(copy_example("npsat2011", tmp_path_factory.mktemp("table") / "campaign") / "table10_x.csv")
    words = ["--reading", "reading_no_ref_dps", "--axis", "x", "--unit", "deg/s", "--scale-factor", "0.5 V/(deg/s)"]
    return ["rate-table", path, *words, "--range", "5 deg/s"]


@pytest.fixture(scope="module", name="long")
def _long(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A record at rest that takes seconds to read and reduce."""
    path = tmp_path_factory.mktemp("long") / "long.npz"
    readings = np.random.default_rng(2).normal(size=(3_000_000, 3))
    stamps = np.arange(len(readings)) / 100.0
    np.savez(path, time=stamps, gyro_x=readings[:, 0], gyro_y=readings[:, 1], gyro_z=readings[:, 2])
    return str(path)


def ended(
    *words: str, env: Mapping[str, str] | None = None, shell: str = "", cwd: Path | None = None
) -> subprocess.CompletedProcess[bytes]:
    """Run a command in a process of its own, with redirections of the shell."""
    line = f'exec "$@" {shell}'
    return subprocess.run(
        ["bash", "-c", line, "bash", *COMMAND, *words],
        capture_output=True,
        check=False,
        env=os.environ | dict(env or {}),
        cwd=cwd,
        timeout=120,
    )


# --- signals


def signal_after(process: subprocess.Popen[str], delay: float, number: int) -> None:
    """Send a signal some time after the process has taken charge of its signals, as the system shows."""
    status = Path(f"/proc/{process.pid}/status")
    begin = time.monotonic()
    while status.exists() and process.poll() is None and time.monotonic() - begin < 20.0:
        caught = re.search(r"SigCgt:\s*(\w+)", status.read_text(encoding="utf-8"))
        if caught is None or int(caught[1], 16) >> (signal.SIGHUP - 1) & 1:
            break
        time.sleep(0.002)
    time.sleep(delay)
    process.send_signal(number)


@pytest.mark.parametrize(
    ("number", "delay"),
    [
        (signal.SIGINT, 1.0),
        (signal.SIGTERM, 0.0),
        (signal.SIGHUP, 0.3),
        *(pytest.param(signal.SIGINT, one, marks=slow) for one in (0.0, 0.3)),
        *(pytest.param(signal.SIGTERM, one, marks=slow) for one in (0.3, 1.0)),
        *(pytest.param(signal.SIGHUP, one, marks=slow) for one in (0.0, 1.0)),
    ],
)
def test_a_signal_ends_with_130_and_one_object(number: signal.Signals, delay: float, long: str) -> None:
    process = subprocess.Popen(
        [*COMMAND, "allan", long, "--unit", "rad/s", "--json"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    signal_after(process, delay, number)
    begin = time.monotonic()
    out, err = process.communicate(timeout=60)
    assert time.monotonic() - begin < 10.0
    assert process.returncode == 130, err
    content = json.loads(out)
    assert content["exit"] == 130
    assert [one["code"] for one in content["errors"]] == ["interrupted"]
    assert content["errors"][0]["what"] == "interrupted: nothing was written"
    assert err == ""


def test_two_signals_give_one_line(long: str) -> None:
    process = subprocess.Popen([*COMMAND, "allan", long, "--unit", "rad/s"], stderr=subprocess.PIPE, text=True)
    signal_after(process, 0.3, signal.SIGINT)
    for _ in range(5):
        process.send_signal(signal.SIGINT)
        time.sleep(0.002)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert err == "error: interrupted: nothing was written\n"


def test_a_campaign_is_interrupted_whole_or_not_at_all(campaign: Path) -> None:
    """At any time: either nothing is written, or out/ is complete and the message says so."""
    statuses = set()
    for delay in (0.0, 0.3, 0.6, 1.2):
        process = subprocess.Popen(
            [*COMMAND, "run", str(campaign)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        signal_after(process, float(delay), signal.SIGTERM)
        _, err = process.communicate(timeout=60)
        statuses.add(process.returncode)
        assert "Traceback" not in err
        if process.returncode == 130:
            last = err.splitlines()[-1]
            whole = f"error: interrupted; the results in {campaign / 'out'} are complete"
            assert last in {"error: interrupted: nothing was written", whole}
            assert last != whole or (campaign / "out" / "results.json").is_file()
        assert not [path for path in campaign.iterdir() if path.name.startswith(".")]
    assert 130 in statuses
    assert statuses <= {130, 4}


def test_native_code_ends_too() -> None:
    """A main thread that never comes back to Python."""
    code = (
        "import ctypes, sys; from inertialcal.cli import process\n"
        "sys.argv = ['inertialcal', 'run', 'x', '--json']; process.own(sys.argv[1:]); print('ready', flush=True)\n"
        "ctypes.PyDLL(None); libc = ctypes.CDLL(None); [libc.sleep(30) for _ in range(9)]"
    )
    # a loop in C without the lock of Python: sleep ends at a signal, so the signal goes to the watching thread alone
    code = code.replace("libc.sleep(30)", "libc.pthread_cond_wait(*LOCK)")
    code = code.replace("[libc.pthread", "LOCK = (ctypes.create_string_buffer(64), ctypes.create_string_buffer(64)); "
                        "libc.pthread_mutex_lock(LOCK[1]); [libc.pthread")  # fmt: skip
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert (process.returncode, err) == (130, "")
    assert json.loads(out)["errors"][0]["code"] == "interrupted"


def test_nohup_is_respected(table: list[str]) -> None:
    process = subprocess.Popen(
        ["bash", "-c", "trap '' HUP; exec \"$@\"", "bash", *COMMAND, *table], stdout=subprocess.PIPE
    )
    time.sleep(0.3)
    process.send_signal(signal.SIGHUP)
    process.communicate(timeout=60)
    assert process.returncode == 0


# --- streams


@pytest.mark.parametrize(("shell", "why"), [(">&-", "it is closed"), ("> /dev/full", "No space left on device")])
@pytest.mark.parametrize(
    "words",
    [
        ["--version"],
        pytest.param(["--help"], marks=slow),
        pytest.param(["TABLE"], marks=slow),
        pytest.param(["TABLE", "--json"], marks=slow),
    ],
)
def test_standard_output_that_cannot_be_written(shell: str, why: str, words: list[str], table: list[str]) -> None:
    done = ended(*(one for word in words for one in (table if word == "TABLE" else [word])), shell=shell)
    assert done.returncode == 3
    assert done.stderr.decode() == f"error: standard output cannot be written: {why}\n"


def test_results_on_disk_are_named_when_they_cannot_be_printed(campaign: Path) -> None:
    done = ended("run", str(campaign), "--json", shell="> /dev/full")
    assert done.returncode == 3
    assert f"the results in {campaign / 'out'} are complete" in done.stderr.decode()


def test_a_quiet_command_needs_no_output(campaign: Path) -> None:
    assert ended("run", str(campaign), "--quiet", shell=">&-").returncode == 4


def test_a_write_error_in_the_middle(table: list[str], tmp_path: Path) -> None:
    line = f'ulimit -f 1; exec "$@" > {tmp_path / "out"}'
    words = [*COMMAND, "rate-table", "--help"]
    done = subprocess.run(["bash", "-c", line, "bash", *words], capture_output=True, check=False, timeout=60)
    assert done.returncode == 3
    assert done.stderr.decode() == "error: standard output cannot be written: File too large\n"


@pytest.mark.parametrize(
    "shell", [*(pytest.param(one, marks=slow) for one in ("2>&-", "2> /dev/full", "<&-")), "2>&- <&-"]
)
def test_other_streams_change_nothing(shell: str, table: list[str]) -> None:
    done = ended(*table, shell=shell)
    assert (done.returncode, done.stderr) == (0, b"")
    assert "scale_factor" in done.stdout.decode()
    assert ended("run", "nowhere", shell=shell).returncode == 3


def test_no_stream_at_all_and_the_file_holds_what_was_written(table: list[str], tmp_path: Path) -> None:
    """A daemon: the first file opened would be standard input, the next standard output."""
    path = tmp_path / "campaign"
    done = ended(*table, "--campaign", str(path), shell=">&- 2>&- <&-")
    assert done.returncode == 3
    assert (path / "campaign.toml").read_text(encoding="utf-8").startswith("schema")
    copied = next((path / "recordings").iterdir())
    assert copied.read_bytes() == Path(table[1]).read_bytes()


def test_a_reader_that_leaves_changes_nothing(campaign: Path) -> None:
    words = ["bash", "-c", '"$@" | head -c 20 > /dev/null; echo ${PIPESTATUS[0]}', "bash", *COMMAND]
    done = subprocess.run([*words, "run", str(campaign), "--json"], capture_output=True, check=True, timeout=60)
    assert done.stdout.strip() == b"4"
    assert done.stderr == b""


def test_an_internal_error_without_a_log_is_one_line(tmp_path: Path) -> None:
    code = (
        "import sys, inertialcal.cli.app as app; from inertialcal.cli import commands\n"
        "def broken(*words): raise ZeroDivisionError('ours')\n"
        "commands.Root.get_command = broken\n"
        "import tempfile; tempfile.tempdir = '/dev/null'\n"
        "from inertialcal.cli.__main__ import entry; sys.argv = ['inertialcal', 'info', 'x']; entry()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 70
    assert "Traceback" not in done.stderr
    assert "no log: Not a directory" in done.stderr
    assert "<string>:2, ours" in done.stderr


# --- encodings


@pytest.mark.parametrize(
    ("env", "encoding"),
    [
        pytest.param({"PYTHONIOENCODING": "ascii"}, "ascii", marks=slow),
        ({"LC_ALL": "C"}, "ascii"),
        pytest.param({"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}, "ascii", marks=slow),
        pytest.param({"LC_ALL": "C", "PYTHONUTF8": "1"}, "utf-8", marks=slow),
        pytest.param({"PYTHONIOENCODING": "latin-1"}, "latin-1", marks=slow),
        pytest.param({"PYTHONIOENCODING": "utf-16"}, "utf-16", marks=slow),
        pytest.param({"PYTHONIOENCODING": "cp1254"}, "cp1254", marks=slow),
    ],
    ids=["ascii", "C", "C alone", "C and utf-8", "latin-1", "utf-16", "turkish"],
)
def test_any_encoding(env: dict[str, str], encoding: str, table: list[str]) -> None:
    done = ended(*table, env=env)
    assert done.returncode == 0, done.stderr
    text = done.stdout.decode(encoding)
    assert ("+/-" if encoding == "ascii" else "±") in text
    content = json.loads(ended(*table, "--json", env=env).stdout.decode(encoding))
    assert content["exit"] == 0


def test_every_sign_of_our_texts_has_an_ascii_form() -> None:
    signs = {
        character
        for path in SOURCE.rglob("*.py")
        if not (text := path.read_text(encoding="utf-8")).isascii() or "\\" in text
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        for character in node.value
        if not character.isascii() and character.isprintable()
    } | set(ASCII)
    codecs.register_error(NEAREST, nearest)
    plain = {sign: sign.encode("ascii", NEAREST).decode() for sign in signs}
    assert {sign for sign, form in plain.items() if form == "?"} <= {"\N{REPLACEMENT CHARACTER}", "\ufffe", "\uffff"}


def test_a_name_that_is_no_utf8(table: list[str], tmp_path: Path) -> None:
    path = os.fsencode(tmp_path) + b"/\xff\xe9.csv"
    with open(path, "wb") as file:
        file.write(b"time [s],gyro_x [deg/s]\n" + b"".join(b"%d,0.1\n" % i for i in range(50)))
    done = subprocess.run([*COMMAND, "info", "--json", path], capture_output=True, check=False, timeout=60)
    assert done.returncode == 0
    assert json.loads(done.stdout.decode("utf-8"))["inputs"][0]["path"].endswith("\ufffd\ufffd.csv")
    for env in ({}, {"PYTHONIOENCODING": "ascii"}):
        shown = subprocess.run(
            [*COMMAND, "info", path], capture_output=True, check=False, timeout=60, env=os.environ | env
        )
        assert shown.returncode == 0
        assert b"gyro_x" in shown.stdout
    refused = subprocess.run([*COMMAND, "psd", path], capture_output=True, check=False, timeout=60)
    assert refused.returncode == 2
    assert "file name is not UTF-8" in refused.stderr.decode()


@slow
def test_a_folder_holds_a_name_that_is_no_utf8(table: list[str], tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_bytes(Path(table[1]).read_bytes())
    (tmp_path / os.fsdecode(b"d\xff.csv")).write_bytes(Path(table[1]).read_bytes())
    done = ended("init", str(tmp_path), "--json")
    assert done.returncode == 0
    (remark,) = [one for one in json.loads(done.stdout)["remarks"] if one["where"] == "d\ufffd.csv"]
    assert (remark["code"], remark["do"]) == ("not_taken", "Rename the file")


@slow
def test_a_campaign_in_a_folder_that_is_no_utf8(campaign: Path, tmp_path: Path) -> None:
    folder = tmp_path / os.fsdecode(b"d\xff")
    copy_example("reinel1969", folder)
    assert ended("run", str(folder), "--quiet").returncode == 4
    content = json.loads((folder / "out" / "provenance.json").read_text(encoding="utf-8"))
    assert "d\ufffd" in json.dumps(content, ensure_ascii=False)


@pytest.mark.parametrize(
    "words",
    [
        ("run",),
        ("info",),
        *(
            pytest.param(one, marks=slow)
            for one in (("check",), ("init",), ("show",), ("simulate", "rate_table", "-o"))
        ),
    ],
)
def test_a_name_too_long_is_refused(words: tuple[str, ...]) -> None:
    done = ended(*words, "x" * 300)
    assert done.returncode == 3
    assert "File name too long" in done.stderr.decode()


def test_a_folder_that_is_gone(table: list[str], tmp_path: Path) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    line = 'cd "$0"; rmdir "$0"; exec "$@"'
    done = subprocess.run(
        ["bash", "-c", line, str(gone), *COMMAND, *table], capture_output=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr


def test_text_files_name_their_encoding() -> None:
    """Files are UTF-8 in every locale."""
    missing = [
        f"{path.relative_to(SOURCE)}:{node.lineno}"
        for path in SOURCE.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and _opens_text(node) and "encoding" not in {word.arg for word in node.keywords}
    ]
    assert missing == []


def _opens_text(call: ast.Call) -> bool:
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    modes = [*call.args, *(word.value for word in call.keywords if word.arg == "mode")]
    binary = any(
        isinstance(mode, ast.Constant) and re.fullmatch("[rwxa+]*b[rwxa+]*", str(mode.value)) for mode in modes
    )
    if name in {"read_text", "write_text"}:
        return isinstance(call.func, ast.Attribute)
    if name == "open":  # members of archives are binary, os.open gives a descriptor
        owner = ast.unparse(call.func).rpartition(".")[0]
        ours = owner.rpartition(".")[2] in {"instrument", "link", "_link", "_opened"}  # those of the lab
        return not binary and not ours and owner not in {"os", "archive", "webbrowser", "nptdms.TdmsFile"}
    return name in {"NamedTemporaryFile", "TextIOWrapper"} and not binary


# --- terminals


def on_terminal(columns: int, *words: str, env: Mapping[str, str] | None = None) -> tuple[int, str]:
    """Run a command on a terminal of a width; return status and what it shows."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    process = subprocess.Popen(
        [*COMMAND, *words], stdin=slave, stdout=slave, stderr=slave, env=os.environ | dict(env or {})
    )
    os.close(slave)
    shown = b"".join(_read(master))
    os.close(master)
    return process.wait(timeout=60), shown.decode().replace("\r\n", "\n")


def _read(descriptor: int) -> Iterator[bytes]:
    while True:
        try:
            part = os.read(descriptor, 65536)
        except OSError:
            return
        if not part:
            return
        yield part


def test_a_narrow_terminal_loses_no_number(table: list[str]) -> None:
    numbers = re.compile(r"(?<![\w.])-?\d+\.\d+")
    wide = set(numbers.findall(ended(*table).stdout.decode()))
    for columns in (20, 1):
        status, shown = on_terminal(columns, *table, "--all")
        assert status == 0
        missing = wide - set(numbers.findall(shown))
        assert not missing, (columns, missing)


@pytest.mark.parametrize(
    "env",
    [
        {"COLUMNS": "1"},
        *(pytest.param({"COLUMNS": one}, marks=slow) for one in ("0", "abc", "20")),
        *(pytest.param(one, marks=slow) for one in ({"TERM": "dumb"}, {"NO_COLOR": "1"}, {"TZ": "No/where"})),
    ],
)
def test_any_environment(env: dict[str, str], table: list[str]) -> None:
    for words in (["--help"], ["rate-table", "--help"], table, ["nonsense"]):
        status, shown = on_terminal(20, *words, env=env)
        assert status in {0, 2}
        assert "Traceback" not in shown


def test_arrow_of_a_command_does_without_pandas() -> None:
    """It is not loaded, of a process of one's own alone, and there where a data frame is wanted."""
    code = """
import sys
import pyarrow as pa
from inertialcal.cli.process import interruption, without_pandas
interruption.noting = sys.argv[1] == "own"
without_pandas()
pa.array([1.0, None])
print("pandas" in sys.modules, len(pa.table({"a": [1, 2]}).to_pandas()))
"""
    for whose, loaded in (("own", "False"), ("other", "True")):
        found = subprocess.run(
            [sys.executable, "-c", code, whose], capture_output=True, text=True, timeout=60, check=True
        )
        assert found.stdout.split() == [loaded, "2"]
