"""Every advice of the messages is obeyed on the file that caused it, and the result is right.

`advice_found` walks the sources for advices; each has a case of `advised_cases`.
"""

from __future__ import annotations

import ast
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from advice_found import SOURCES, Advice, advices
from advised_cases import CASES, INSTALLS, Case
from advised_more import MORE
from files_for_advice import write_files
from records_for_advice import write_records

import inertialcal as ic
from inertialcal.core.errors import InertialcalError
from typed_commands import call

FEW = 5.0  # standard uncertainties that an estimate may be off
ROUND = 3e-3  # deg/s: of readings rounded to counts
SQRT_RATE = np.sqrt(50.0)
MADE = {name: shlex.split(line) for name, line in {  # models, terms and campaigns, made when a line names them
    "model.json": "rate-table turned_units.csv --axis x -o model.json",
    "thermal.json": "thermal chamber_units.csv -o thermal.json",
    "counts.json": 'rate-table turned_counts.csv --axis x --lsb "5 V / 4095" --reference "2.5 V" '
                   '--scale-factor "0.02 V/(deg/s)" -o counts.json',
    "volts.json": 'thermal chamber_volts.csv --reference "2.5 V" --scale-factor "0.02 V/(deg/s)" -o volts.json',
    "gauge.json": "sensitivity gauge_1.csv gauge_2.csv --to pressure -o gauge.json",
    "supply.json": "sensitivity levels.csv levels_2.csv --to supply -o supply.json",
    "acc.json": "positions faces_bare.csv --unit acc=m/s2 -o acc.json",
    "acc_thermal.json": "thermal acc_chamber.csv -o acc_thermal.json",
    "coded.json": 'rate-table turned_counts.csv --axis x --lsb "5 V / 4095" --reference "2.5 V" '
                  '--scale-factor "0.02 V/(deg/s)" --counts "0, 4095" -o coded.json',
    "wide.json": 'rate-table turned_counts.csv --axis x --lsb "5 V / 4095" --reference "2.5 V" '
                 '--scale-factor "0.02 V/(deg/s)" --counts "0, 33554431" -o wide.json',
    "rig_table": "simulate rate_table -o rig_table",
    "rig_table/out": "run rig_table",
    "rig_ground": "simulate sams_tsh_model -o rig_ground",
    "certified_2/out": "run certified_2",
    "rig_mesa": "simulate mesa -o rig_mesa",
    "rig_mesa_2": "simulate mesa -o rig_mesa_2 --seed 2",
    "rig_turned": "simulate turned_mass -o rig_turned",
    "rig_mesa/out": "run rig_mesa",
    "rig_mesa_2/out": "run rig_mesa_2",
    "shared_1/out": "run shared_1",
    "shared_2/out": "run shared_2",
    "edited/out": "run edited",
}.items()}  # fmt: skip
PATIENCE = 60.0  # for a command that is cut off [s]
LARGEST = 200_000  # bytes of a written file that is looked into

OF_MODULE = {"serial": "pyserial"}  # packages whose modules are called otherwise


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder with all files."""
    found = tmp_path_factory.mktemp("advised")
    write_files(found)
    write_records(found)
    return found


def strings(content: Any) -> Iterator[str]:
    """Yield every text of an object."""
    if isinstance(content, dict):
        content = list(content.values())
    if isinstance(content, list):
        for one in content:
            yield from strings(one)
    elif isinstance(content, str):
        yield content


def _by_hand(what: str, name: str, before: str = "", after: str = "") -> None:
    """Delete a file, or edit it, or cut it off as a loss of power does."""
    if what == "halve":
        os.truncate(name, os.path.getsize(name) // 2)
        return
    file = Path(name)
    text = file.read_text(encoding="utf-8")
    file.unlink() if what == "rm" else file.write_text(text.replace(before, after), encoding="utf-8")


def _cut_off(words: Sequence[str]) -> str:
    """Type a command and Ctrl-C once it has begun; return what it says."""
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-m", "inertialcal", *words]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=env)
    begun, end = Path(words[words.index("-o") + 1]) / "ledger.sqlite", time.monotonic() + PATIENCE
    while not begun.exists() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, said
    return said


def typed(capsys: pytest.CaptureFixture[str], line: str) -> tuple[int, Any, str]:
    """Type a command; return exit status, its object, and all that it says. ``text`` before it: without ``--json``."""
    words = shlex.split(line)
    if words[0] in ("halve", "rm", "edit"):
        _by_hand(*words)
        return 0, {}, ""
    if words[0] == "cut":
        return 130, {}, _cut_off(words[1:])
    if words[0] == "python":
        try:
            return 0, {}, str(getattr(ic, words[1])(*words[2:]))
        except InertialcalError as error:
            return 3, {}, str(error)
    plain = words[0] in ("text", "tty")
    if plain or words[-1] == "--help":
        with pytest.MonkeyPatch.context() as patch:
            if words[0] == "tty":
                patch.setattr(sys.stdout, "isatty", lambda: True)
            status, out, err = call(capsys, *words[plain:])
        return status, {}, f"{out}\n{err}"
    into = Path(words.pop()) if words[-2:-1] == [">"] else None
    status, out, err = call(capsys, *[one for one in words if one not in (">", "--json")], "--json")
    if into is not None:
        into.write_text(out, encoding="utf-8")
    content = json.loads(out)
    return status, content, "\n".join([*strings(content), err, _written(words)])


def _written(words: Sequence[str]) -> str:
    """Return the text that a command wrote with ``-o``, the campaign that it simulated, what a run was made of."""
    path = Path(words[words.index("-o") + 1]) if "-o" in words else Path()
    path = path / "campaign.toml" if words[0] == "simulate" else path
    path = Path(words[1]) / "out" / "provenance.json" if words[0] == "run" else path
    is_text = path.is_file() and path.suffix not in (".png", ".pdf", ".mcap") and path.stat().st_size < LARGEST
    return path.read_text(encoding="utf-8") if is_text else ""


def need(line: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Make the models and campaigns that a line speaks of, once."""
    for name, command in MADE.items():
        if re.search(rf"(?<![\w.]){re.escape(name.split('/')[0])}(?![\w.])", line) and not (folder / name).exists():
            assert call(capsys, *command)[0] in (0, 4)


def check(right: str, content: Any, said: str, folder: Path) -> None:
    """Check what came out against what the files were made of."""
    what, *rest = right.split(" ")
    results = content.get("results", [])
    sensor, _, quantity = what.rpartition(".")
    rows = [one for one in results if one.get("method") == "result" and one["status"] == "estimated"]
    own = [one for one in rows if one["axis"] in rest and sensor in ("", one["sensor"])
           and (one["quantity"] == quantity or (what == "white" and "random_walk" in one["quantity"]))]  # fmt: skip
    if own:
        value, u, true = own[0]["value"], own[0]["u"], float(rest[1])
        if what == "white":
            true = true / SQRT_RATE * (60.0 if own[0]["unit"] == "deg/sqrt(h)" else 1.0)
            assert value == pytest.approx(true, rel=0.2)
        else:
            assert abs(value - true) <= FEW * u + (ROUND if own[0]["unit"] == "deg/s" else 0.0), own[0]
    elif what == "value":
        values = [one["value"] for one in results if one["quantity"] == rest[0] and one["value"]]
        assert any(one == pytest.approx(float(rest[1]), rel=0.01) for one in values), values
    elif what == "noise":
        (budget,) = content["budgets"]
        (line,) = [one for one in budget["lines"] if one["source"] == "noise at rest"]
        assert line["size"] == pytest.approx([np.radians(float(rest[0])) / SQRT_RATE] * 3, rel=0.2)
    elif what in ("rate", "start", "unit", "mean"):
        check_info(what, rest, results[0])
    elif what in ("has", "lacks"):
        assert (" ".join(rest) in said) == (what == "has")
    elif what in ("file", "pdf", "rows"):
        check_file(what, folder / rest[0], rest[1:])
    elif what == "score":
        (row,) = [one for one in results if one["quantity"] == rest[0]]
        assert row["inside"], row
    elif what == "zero":  # at rest, a compensated gyro reads zero; turned, what the table turned
        assert abs(np.median(first_axis(folder / rest[0]))) < 0.05
    elif what == "flat":  # it no longer follows its condition
        assert np.ptp([np.median(one) for one in np.split(first_axis(folder / rest[0]), 12)]) < 0.02
    else:
        assert what == "done"


def check_file(what: str, path: Path, rest: Sequence[str]) -> None:
    """Check a file that was written: a page, a PDF, a list of so many rows."""
    if what == "rows":
        assert sum(line[:1].isdigit() for line in path.read_text(encoding="utf-8").splitlines()) == int(rest[0])
    else:
        assert path.read_bytes().startswith(b"%PDF" if what == "pdf" else b"<!")


def first_axis(path: Path) -> np.ndarray:
    """Return the readings of the x axis of a file that was written."""
    head, *lines = path.read_text().splitlines()
    column = next(i for i, name in enumerate(head.split(",")) if re.match(r"(gyro_)?x\b|a\b", name))
    return np.array([float(line.split(",")[column]) for line in lines])


def check_info(what: str, rest: Sequence[str], found: dict[str, Any]) -> None:
    """Check what ``info`` says of a file."""
    channel: dict[str, Any] = next((one for one in found["channels"] if one["name"].split(" ")[0] == rest[0]), {})
    if what == "rate":
        assert found["time"]["sample_rate"] == pytest.approx(float(rest[0]), rel=1e-3)
    elif what == "start":
        assert found["time"]["start"].startswith(rest[0])
    elif what == "unit":
        assert channel["unit"] == rest[1]
    else:
        assert channel["mean"] == pytest.approx(float(rest[1]), rel=1e-9)


def obey(case: Case, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Type, get the advice, do what it says, and look whether the result is right."""
    need(f"{case.typed} {case.obeyed}", folder, capsys)
    for line in case.typed.split(" ; "):
        _, _, said = typed(capsys, line)
    assert Advice("", case.advice).gave(said), said
    obeyed = (
        case.typed.split(" ; ")[-1].removeprefix("text ") + case.obeyed[1:]
        if case.obeyed.startswith("+")
        else case.obeyed
    )
    flat = " ".join(said.split())
    for option in set(re.findall(r"(?<=\s)--?[a-z][a-z-]*", obeyed)) - set(
        re.findall(r"(?<=\s)--?[a-z][a-z-]*", case.typed)
    ):
        assert re.search(rf"(?<![\w-]){option}\b", flat) or option in ("--yes", "--help", "-o"), (option, flat)
    content: dict[str, Any] = {}
    status, after = 0, ""
    for line in obeyed.split(" ; "):
        status, content, after = typed(capsys, line)
        assert status == 0 or (status == 4 and "run" in line.split()[:2]), (line, after)
    check(case.right, content, after, folder)


@pytest.mark.parametrize(
    "case",
    [pytest.param(one, marks=() if one.quick else pytest.mark.slow, id=one.typed[:60]) for one in (*CASES, *MORE)],
)
def test_an_advice_that_is_obeyed_gives_what_is_right(
    case: Case, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    obey(case, folder, capsys)


def test_every_advice_of_the_sources_is_obeyed() -> None:
    found, obeyed = {one.template: one.where for one in advices()}, {one.advice for one in (*CASES, *MORE)}
    left = {template: where for template, where in found.items()
            if template not in obeyed and not INSTALLS.match(template)}  # fmt: skip
    assert not left, f"write a case for: {left}"
    assert not (gone := obeyed - found.keys()), f"no message says it any more: {gone}"


def test_an_extra_to_install_holds_what_was_missing() -> None:
    """The network is not tried; what is imported where the advice stands is a package of the extra that it names."""
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
    extras = {name: {re.split(r"[<>=\[ ]", one)[0].lower() for one in packages}
              for name, packages in project["optional-dependencies"].items()}  # fmt: skip
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for path in SOURCES.rglob("*.py")
             if re.search(r"pip install|library\(|package\(", path.read_text(encoding="utf-8"))}  # fmt: skip
    advised = [one for one in advices() if INSTALLS.match(one.template)]
    assert len(advised) >= len(extras.keys() & {"pdf", "sign", "frame", "formats"})
    for one in advised:
        extra = INSTALLS.match(one.template)[1]  # type: ignore[index]
        path, line = SOURCES / one.where.split(":")[0], int(one.where.split(":")[1])
        (tried,) = [node for node in ast.walk(trees[path]) if isinstance(node, ast.Try)
                    and node.lineno < line <= (node.end_lineno or 0)]  # fmt: skip
        named = {name.name for node in tried.body if isinstance(node, ast.Import) for name in node.names}
        named |= {module for node in tried.body for module in _literals(node, "import_module")}
        named |= {
            name
            for node in tried.body
            if isinstance(node, ast.ImportFrom) and node.level
            for name in _foreign(path.parents[node.level - 1], node.module or "") & set.union(*extras.values())
        }
        (around,) = [node.name for node in ast.walk(trees[path]) if isinstance(node, ast.FunctionDef)
                     and node.lineno < line <= (node.end_lineno or 0)] if not named else [""]  # fmt: skip
        named |= {module for tree in trees.values() for module in _literals(tree, around)} if around else set()
        packages = {OF_MODULE.get(name, name.partition(".")[0].replace("_", "-")) for name in named}
        assert packages, one
        assert packages <= extras[extra], one


def _foreign(folder: Path, module: str) -> set[str]:
    """Return the packages that a module of ours imports."""
    tree = ast.parse(folder.joinpath(*module.split(".")).with_suffix(".py").read_text(encoding="utf-8"))
    names = {name.name for node in ast.walk(tree) if isinstance(node, ast.Import) for name in node.names}
    names |= {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and not node.level}
    return {name.partition(".")[0].replace("_", "-") for name in names}


def _literals(tree: ast.AST, function: str) -> set[str]:
    """Return the first arguments of the calls of a function."""
    return {node.args[0].value for node in ast.walk(tree) if isinstance(node, ast.Call)
            and getattr(node.func, "attr", getattr(node.func, "id", "")) == function
            and isinstance(node.args[0], ast.Constant) and isinstance(node.args[0].value, str)}  # fmt: skip
