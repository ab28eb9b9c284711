"""Special inputs: fixed cases, each by its name, and special files in every place where a command takes a path."""

from __future__ import annotations

import io
import json
import os
import signal
import socket
import stat
import subprocess
import time
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import h5py
import numpy as np
import pyarrow as pa
from forked import Process, Ran, program
from mutations import sealed
from pyarrow import parquet
from scipy import io as scipy_io
from seed_files import csv_text, read_csv

SECRET = b"do not read this: a file of the machine, not of the input, 64 bytes.."
Prepare = Callable[[Path], None]
Check = Callable[[Path, Ran], list[str]]


def nothing(_: Path) -> None:
    """Change no file."""


def no_more(_: Path, __: Ran) -> list[str]:
    """Look at nothing more."""
    return []


@dataclass(frozen=True)
class Special:
    """A fixed case.

    Parameters
    ----------
    name : str
        Its row in the table.
    line : str
        The command; words that name seeds have them copied.
    prepare : callable
        What is done to the files first.
    statuses : set of int
        Exit statuses that are right.
    outputs : tuple of str
        Paths that it may make or change.
    check : callable
        Folder and end -> what is wrong with it, beyond what holds for all.
    process : Process
        A process of its own; None for a fork.
    needs : tuple of str
        More seeds.
    """

    name: str
    line: str
    prepare: Prepare = nothing
    statuses: frozenset[int] = frozenset({0, 1, 2, 3, 4})
    outputs: tuple[str, ...] = ()
    check: Check = no_more
    process: Process | None = None
    needs: tuple[str, ...] = ()


REFUSED = frozenset({2, 3})


def specials() -> Iterator[Special]:
    """Yield all cases."""
    yield from _bombs()
    yield from _numbers()
    yield from _results()
    yield from _streams()
    yield from _special_files()


# Files that promise more than they hold


def _bombs() -> Iterator[Special]:
    for word in ("info bomb", "convert bomb made.csv", "allan bomb --sample-rate 10"):
        outputs: tuple[str, ...] = ("made.csv",) if "made" in word else ()
        for name, ending, make in (
            ("MAT 5, class byte 6 -> 5", ".mat", _class_byte),
            ("HDF5, external storage", ".h5", _external),
            ("HDF5, virtual dataset", ".h5", _virtual),
            ("HDF5, link to another file", ".h5", _linked),
            ("HDF5, 120 million never written", ".h5", lambda path: _never_written(path, 120_000_000)),
            ("HDF5, 500 million never written", ".h5", lambda path: _never_written(path, 500_000_000)),
            ("Parquet, one string 20,000 times", ".parquet", _dictionary),
            ("npz, 200,000 members", ".npz", _members),
            ("100,000 columns", ".csv", _columns),
        ):
            line = word.replace("bomb", f"bomb{ending}")
            refused = name.startswith("HDF5, ") and "never" not in name

            def prepare(folder: Path, make: Prepare = make, ending: str = ending) -> None:
                (folder / "secret").write_bytes(SECRET)
                make(folder / f"bomb{ending}")

            yield Special(name, line, prepare, REFUSED if refused else frozenset({0, 2, 3}), outputs, _no_secret)


def _no_secret(folder: Path, end: Ran) -> list[str]:
    made = folder / "made.csv"
    words = end.out + end.err + (made.read_text(errors="replace") if made.exists() else "")
    seen = (repr(number)[:8] for number in np.frombuffer(SECRET[:64], "<f8").tolist())
    return ["another file of the machine is in the output"] if any(one in words for one in seen) else []


def _class_byte(path: Path) -> None:
    scipy_io.savemat(path, {"t": np.arange(9.0) / 7, "x": np.ones(9)})
    content = bytearray(path.read_bytes())
    content[128 + 16] = 5
    path.write_bytes(content)


def _external(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file.create_dataset("x", (8,), "f8", external=[(str(path.with_name("secret")), 0, 64)])


def _virtual(path: Path) -> None:
    layout = h5py.VirtualLayout((8,), "f8")
    layout[:] = h5py.VirtualSource(str(path.with_name("secret")), "x", (8,))
    with h5py.File(path, "w") as file:
        file.create_virtual_dataset("x", layout)


def _linked(path: Path) -> None:
    with h5py.File(path.with_name("other.h5"), "w") as other:
        other["x"] = np.frombuffer(SECRET[:64], "<f8")
    with h5py.File(path, "w") as file:
        file["x"] = h5py.ExternalLink("other.h5", "/x")


def _never_written(path: Path, size: int) -> None:
    with h5py.File(path, "w") as file:
        file.create_dataset("x", (size,), "f8", chunks=(1_000_000,))


def _dictionary(path: Path) -> None:
    text = "x" * 400_000
    column = pa.DictionaryArray.from_arrays(pa.array(np.zeros(20_000, "i4")), pa.array([text]))
    parquet.write_table(pa.table({"t": np.arange(20_000.0), "x": column}), path)


def _members(path: Path) -> None:
    member = io.BytesIO()
    np.save(member, np.zeros(1))
    with zipfile.ZipFile(path, "w") as archive:
        for number in range(200_000):
            archive.writestr(zipfile.ZipInfo(f"x{number}.npy"), member.getvalue())


def _columns(path: Path) -> None:
    rows = [",".join(f"c{number}" for number in range(100_000)), *[",".join(["1"] * 100_000)] * 3]
    path.write_text("\n".join([*rows, ""]), encoding="utf-8")


# Numbers


def _numbers() -> Iterator[Special]:
    thermal = "thermal thermal1.csv --column x=gyro_x --column temperature=t_x"
    for rows in (10, 20, 40):
        yield Special(f"thermal, first {rows} rows", thermal, _first("thermal1.csv", rows))
    yield Special("thermal, shuffled temperature", thermal, lambda folder: _reordered(folder, "shuffled"))
    yield Special("thermal, alternating temperature", thermal, lambda folder: _reordered(folder, "alternating"))
    for line in (
        "info still.csv",
        "allan still.csv --unit x=deg/s --column x",
        "psd still.csv --unit x=deg/s --column x",
        'sine mass1.csv --column pulses --period "480 s"',
        thermal,
        "rate-table rates.csv --axis y",
        "flip flip.csv --unit ug --column x=x --column y=y --column z=z",
        'positions held.csv --unit acc=m/s2 --unit gyro=rad/s --gravity "9.807 m/s2"',
        'positions faces.csv --gravity "9.807 m/s2"',
        'mass-attraction mass1.csv --schedule schedule.csv --column x=pulses --gate "100 s"',
        "convert held.csv made.csv",
        "compensate acc.json held.csv -o made.csv --unit acc=m/s2 --unit gyro=rad/s",
    ):
        made = ("made.csv",) if "made" in line else ()
        file = line.replace("acc.json ", "").split()[1]
        yield Special("readings x 1e160", line, _scaled_file(file), outputs=made)
    for line in (
        "show model.json",
        "compare model.json acc.json",
        "export model.json --to c -o made.h --unjudged",
        "compensate model.json thermal1.csv -o made.csv --temperature t_x --unit gyro=deg/s",
    ):
        outputs = tuple(word for word in line.split() if word.startswith("made"))
        yield Special("model with 1e400", line, _huge_in_model, REFUSED, outputs)
        yield Special("model with text for a pair", line, _text_in_model, REFUSED, outputs)
        yield Special("newline in a model's text", line, _newline_in_model, outputs=outputs, check=_not_forged)
    yield Special("compare, u = 1e206", "compare rig_mesa/out/results.json example_sams1996/out/results.json", _large_u)
    yield Special("compare, u = 1e206", "compare rig_mesa rig_mesa/out/results.json", _large_u)
    for setting in ("body.mass=1e150 kg", "body.cube=1e150 cm", "body.stand_off=1e150 cm", "body.density=1e150 kg/m^3"):
        body = '--set "body.cube=10 cm" --set "body.mass=500 kg" --set "body.stand_off=7.6 cm"'
        stroke = '--set "motion.stroke=10 cm, 40 cm"'
        yield Special("mass attraction, 1e150", f'plan mass-attraction {body} {stroke} --set "{setting}"')
        yield Special("mass attraction, 1e150", f'plan mass-attraction moved.toml --set "{setting}"')


def _first(name: str, rows: int) -> Prepare:
    def prepare(folder: Path) -> None:
        lines = (folder / name).read_text(encoding="utf-8").splitlines()
        (folder / name).write_text("\n".join([*lines[: rows + 1], ""]), encoding="utf-8")

    return prepare


def _reordered(folder: Path, how: Literal["shuffled", "alternating"]) -> None:
    path = folder / "thermal1.csv"
    table = read_csv(path.read_text(encoding="utf-8"))
    name = next(one for one in table if one.startswith("t_x"))
    if how == "shuffled":
        table[name] = np.random.default_rng(1).permutation(table[name])
    else:
        table[name][::2], table[name][1::2] = "20.0", "30.0"
    path.write_text(csv_text(table), encoding="utf-8")


def _scaled_file(name: str) -> Prepare:
    def prepare(folder: Path) -> None:
        path = folder / name
        table = read_csv(path.read_text(encoding="utf-8"))
        for one in [*table][1:]:
            table[one] = np.array([f"{float(cell or 'nan') * 1e160!r}" for cell in table[one]], dtype=object)
        path.write_text(csv_text(table), encoding="utf-8")

    return prepare


def _in_model(folder: Path, change: Callable[[dict[str, Any]], None]) -> None:
    path = folder / "model.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    change(content)
    path.write_text(json.dumps(sealed(content)), encoding="utf-8")


def _huge_in_model(folder: Path) -> None:
    path = folder / "model.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    text = json.dumps(content)
    number = json.dumps(_first_number(content["matrix"]["values"] if "matrix" in content else content))
    path.write_text(text.replace(number, "1e400", 1), encoding="utf-8")


def _first_number(tree: Any) -> float:
    if isinstance(tree, float):
        return tree
    inner = tree.values() if isinstance(tree, dict) else tree if isinstance(tree, list) else ()
    return next((found for found in map(_first_number, inner) if found), 0.0)


def _text_in_model(folder: Path) -> None:
    def change(content: dict[str, Any]) -> None:
        for parent, key in _pairs(content):
            parent[key] = "text"

    _in_model(folder, change)


def _pairs(tree: Any) -> Iterator[tuple[Any, Any]]:
    """Yield parent and key of each pair of numbers."""
    for key, one in list(tree.items() if isinstance(tree, dict) else enumerate(tree)):
        if isinstance(one, list) and len(one) == 2 and all(isinstance(x, int | float) for x in one):
            yield tree, key
        elif isinstance(one, dict | list):
            yield from _pairs(one)


FORGED = "judged: PASS, forged"


def _newline_in_model(folder: Path) -> None:
    def forge(tree: Any) -> None:
        for key, one in list(tree.items() if isinstance(tree, dict) else enumerate(tree)):
            if isinstance(one, str) and key in {"title", "source", "campaign", "certificate", "serial", "what", "part"}:
                tree[key] = f"{one}\n{FORGED}"
            elif isinstance(one, dict | list):
                forge(one)

    _in_model(folder, forge)


def _not_forged(_: Path, end: Ran) -> list[str]:
    return ["a forged line is printed"] if f"\n{FORGED}" in end.out else []


def _large_u(folder: Path) -> None:
    path = folder / "rig_mesa/out/results.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    for row in content["results"]:
        if row["u"] is not None:
            row["u"] = 1e206
    path.write_text(json.dumps(sealed(content), indent=1), encoding="utf-8")


# Results, and what lies with them


def _results() -> Iterator[Special]:
    out = ("rig_mesa/out",)
    yield Special("FIFO at out/results.json", "run rig_mesa", _fifo_in_out, outputs=out)
    yield Special("FIFO at out/results.json", "show rig_mesa/out", _fifo_in_out)
    yield Special("FIFO at out/results.json", "compare rig_mesa rig_mesa", _fifo_in_out)
    yield Special("out/mynotes.txt", "run rig_mesa", _notes, outputs=out, check=_notes_kept)
    for line in ("show rig_mesa/out", "compare rig_mesa/out/results.json rig_mesa/out/results.json", "score rig_mesa"):
        yield Special("hand-edited results.json", line, _edited, check=_edit_noticed)
    again = "compensate acc.json once.csv -o made.csv --unit acc=m/s2 --unit gyro=rad/s"
    needs = ("acc.json", "held.csv")
    yield Special("compensate twice", again, _compensated, REFUSED, ("made.csv",), needs=needs)
    for ending in (".csv", ".parquet", ".npz"):
        line = f"convert formula.csv made{ending}"
        yield Special("header =cmd|", line, _formula, outputs=(f"made{ending}",), check=_no_formula)


def _fifo_in_out(folder: Path) -> None:
    path = folder / "rig_mesa/out/results.json"
    path.unlink()
    os.mkfifo(path)


def _notes(folder: Path) -> None:
    (folder / "rig_mesa/out/mynotes.txt").write_text("mine", encoding="utf-8")


def _notes_kept(folder: Path, _: Ran) -> list[str]:
    path = folder / "rig_mesa/out/mynotes.txt"
    return [] if path.is_file() and path.read_text(encoding="utf-8") == "mine" else ["out/mynotes.txt is lost"]


def _edited(folder: Path) -> None:
    path = folder / "rig_mesa/out/results.json"
    text = path.read_text(encoding="utf-8")
    row = next(one for one in json.loads(text)["results"] if one["value"])
    path.write_text(text.replace(json.dumps(row["value"]), json.dumps(2 * row["value"]), 1), encoding="utf-8")


def _edit_noticed(_: Path, end: Ran) -> list[str]:
    noticed = end.status in REFUSED or "edited" in end.out + end.err
    return [] if noticed else ["the edit was not noticed"]


def _compensated(folder: Path) -> None:
    words = ["compensate", "acc.json", "held.csv", "-o", "once.csv", "--unit", "acc=m/s2", "--unit", "gyro=rad/s"]
    called(words, folder)


def called(words: Sequence[str], folder: Path) -> None:
    """Run a command as a process, which must succeed."""
    subprocess.run(program(words), cwd=folder, check=True, capture_output=True)


def _formula(folder: Path) -> None:
    rows = [f"{number},{number}.5,{number}.25" for number in range(50)]
    head = "t,=cmd|' /C calc'!A1,@SUM(1+1)"
    (folder / "formula.csv").write_text("\n".join([head, *rows, ""]), encoding="utf-8")


def _no_formula(folder: Path, _: Ran) -> list[str]:
    made = folder / "made.csv"
    head = made.read_text(encoding="utf-8").splitlines()[:3] if made.exists() else []
    cells = [cell.strip('"') for line in head for cell in line.split(",")]
    return [f"a spreadsheet computes {cell}" for cell in cells if cell.startswith(("=", "@", "+cmd"))]


# Standard output, and signals


def _streams() -> Iterator[Special]:
    lines = (
        "info still.csv",
        "show model.json",
        "show rig_mesa/out",
        "check rig_mesa",
        "run rig_still_gyro",
        "allan still.csv --unit x=deg/s --column x",
        "plan mass-attraction moved.toml",
        "compare rig_mesa rig_mesa",
        "info nothing.csv",
    )
    ascii_only = {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C", "PYTHONIOENCODING": "ascii"}
    for line in lines:
        for more in ("", " --json"):
            folders = [word for word in line.split() if line.startswith("run") and word != "run"]
            outputs = tuple(f"{one}/{kept}" for one in folders for kept in ("out", "out-cache"))
            for name, process, check in (
                ("ASCII standard output", Process(settings=ascii_only), no_more),
                ("terminal of 20 columns", Process(settings={"COLUMNS": "20"}), no_more),
                ("standard output on a full device", Process("full"), _no_fault),
                ("closed standard output", Process("closed"), _no_fault),
            ):
                yield Special(name, line + more, outputs=outputs, check=check, process=process)
    yield Special("SIGINT in a run", "run rig_mesa", check=_interrupted(signal.SIGINT), outputs=("rig_mesa/out",))
    yield Special("SIGTERM in a run", "run rig_mesa", check=_interrupted(signal.SIGTERM), outputs=("rig_mesa/out",))


def _no_fault(_: Path, end: Ran) -> list[str]:
    return ["says that it is a fault of inertialcal"] if "fault of inertialcal" in end.err else []


def _interrupted(what: signal.Signals) -> Check:
    """Return a check: a run that gets a signal later and later ends with 130 in words, or is done."""

    def check(folder: Path, _: Ran) -> list[str]:
        found = []
        for later in (0.2, 0.8, 1.4, 2.0):
            run = subprocess.Popen(
                program(["run", "rig_mesa"]), cwd=folder, stderr=subprocess.PIPE, stdout=subprocess.PIPE
            )
            time.sleep(later)
            run.send_signal(what)
            told = run.communicate(timeout=60)[1]
            started = later > 0.5
            if started and (run.returncode not in {0, 1, 4, 130} or (run.returncode == 130 and not told.strip())):
                found.append(f"{what.name} after {later} s: exit {run.returncode}, {told.decode()[-100:]!r}")
            if not (folder / "rig_mesa/out/results.json").exists():
                found.append(f"{what.name} after {later} s: out/ is lost")
        return found

    return check


# Special files, wherever a path is taken

KINDS = ("FIFO", "socket", "device /dev/full", "device /dev/zero", "folder", "link to itself", "unreadable file")
LINKS = ("link to itself", "unreadable file")
TAKEN = (
    "info SPECIAL.csv",
    "allan SPECIAL.csv",
    "thermal SPECIAL.csv thermal1.csv",
    "positions acc=SPECIAL.csv --gravity 9.8",
    "sine mass1.csv --column pulses --schedule SPECIAL.csv",
    "mass-attraction mass1.csv --schedule SPECIAL.csv --column x=pulses",
    "positions held.csv --unit acc=m/s2 --gravity 9.8 --sections SPECIAL.json",
    "allan still.csv --unit x=deg/s --column x --chain SPECIAL.toml",
    "allan still.csv --like SPECIAL",
    "convert SPECIAL.csv made.csv",
    "compensate SPECIAL.json held.csv -o made.csv",
    "compensate acc.json SPECIAL.csv -o made.csv",
    "show SPECIAL.json",
    "show SPECIAL.json/out",
    "export SPECIAL.json --to c -o made.h --unjudged",
    "export acc.json --with SPECIAL.json --to imucal -o made.json --unjudged",
    "compare SPECIAL.json acc.json",
    "compare acc.json SPECIAL.json",
    "plan mass-attraction SPECIAL.toml",
    "plan mass-attraction moved.toml --set noise.file=SPECIAL.json --set noise.axis=x",
    "programme-1969 SPECIAL.cards",
    "check SPECIAL",
    "run SPECIAL",
    "score SPECIAL",
    "init SPECIAL",
    "check rig_mesa/SPECIAL:campaign.toml",
    "check rig_mesa/SPECIAL:schedule.csv",
    "run rig_mesa/SPECIAL:recordings/run1.csv",
    "score rig_mesa/SPECIAL:.truth/truth.json",
    "show rig_mesa/SPECIAL:out/results.json",
    "show rig_mesa/SPECIAL:out/curves.parquet",
    "show rig_mesa/SPECIAL:out",
)
MADE = (
    "convert still.csv SPECIAL.csv",
    "convert still.csv SPECIAL.parquet",
    "allan still.csv --unit x=deg/s --column x -o SPECIAL.svg",
    "allan still.csv --unit x=deg/s --column x -o SPECIAL",
    "allan still.csv --unit x=deg/s --column x --campaign SPECIAL",
    "compensate acc.json held.csv -o SPECIAL.csv --unit acc=m/s2 --unit gyro=rad/s",
    "export acc.json --to c -o SPECIAL.h --unjudged",
    "show acc.json -o SPECIAL.svg",
    "plan mass-attraction --write-example SPECIAL.toml",
    "plan mass-attraction moved.toml --schedule SPECIAL.csv",
    "programme-1969 deck.cards -o SPECIAL",
    "simulate still_gyro -o SPECIAL",
    "run rig_mesa/SPECIAL:out",
    "run rig_mesa/SPECIAL:out/report.html",
    "run rig_mesa/SPECIAL:out/extra",
    "init rig_mesa/SPECIAL:campaign.toml",
)
MARK = "SPECIAL"


def _special_files() -> Iterator[Special]:
    for kind in KINDS:
        for what, lines in (("read", TAKEN), ("written", MADE)):
            for line in lines:
                command, path = placed(line)
                replaced = kind == "folder" or kind in LINKS  # a link is replaced like a file
                outputs: tuple[str, ...] = (path,) if replaced and what == "written" else ()
                if line.startswith("run"):
                    outputs = ("rig_mesa/out",)
                elif "made" in line:
                    outputs = tuple(word for word in line.split() if word.startswith("made"))

                def prepare(folder: Path, kind: str = kind, path: str = path) -> None:
                    put_special(kind, folder / path)

                def check(
                    folder: Path, _: Ran, kind: str = kind, path: str = path, outputs: tuple[str, ...] = outputs
                ) -> list[str]:
                    place = folder / path  # `run` may move it aside, into out/kept-1
                    moved = (one / place.name for one in place.parent.glob("kept-*"))
                    kept = kind == "folder" or path in outputs or any(map(_is_special, (place, *moved)))
                    return [] if kept else [f"{path} is lost"]

                yield Special(f"special file, {what}: {kind}", command, prepare, outputs=outputs, check=check)


def placed(line: str) -> tuple[str, str]:
    """Return the command of a line and the path that is special: ``folder/SPECIAL:path`` is a path in a folder."""
    word = next(one for one in line.replace("=", " ").split() if MARK in one)
    if ":" not in word:
        return line.replace(MARK, "special"), word.replace(MARK, "special").removesuffix("/out")
    folder, path = word.split(f"/{MARK}:")
    return line.replace(word, f"{folder}/out" if line.startswith("show") else folder), f"{folder}/{path}"


def _is_special(path: Path) -> bool:
    return path.is_symlink() or (path.exists() and not path.is_file() and not path.is_dir())


def put_special(kind: str, path: Path) -> None:
    """Put a special file at a path, in place of what is there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.exists():
        path.rename(path.with_name(f"{path.name}.before"))
    match kind:
        case "FIFO":
            os.mkfifo(path)
        case "socket":
            here = Path.cwd()
            os.chdir(path.parent)  # the name of a socket is short
            with socket.socket(socket.AF_UNIX) as made:
                made.bind(path.name)
            os.chdir(here)
        case "folder":
            path.mkdir()
        case "link to itself":
            path.symlink_to(path.name)
        case "unreadable file":
            path.symlink_to("/proc/self/mem")  # a mode does not keep root out; this gives an error to anybody
        case _:
            _device(path, {"device /dev/full": (1, 7), "device /dev/zero": (1, 5)}[kind], kind.split()[1])


def _device(path: Path, number: tuple[int, int], name: str) -> None:
    """Make a device, or a link to one where only root may make it: root would replace the device itself."""
    try:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(*number))
    except PermissionError:
        path.symlink_to(name)
