"""Hashes of what the program writes and prints: the same before and after a change that must not move a figure.

Examples and simulated rigs (seed 1) are run as campaigns; every other command is then called on their files, in
several variants, with and without ``--json``, refusals too. Each output gives one line: SHA-256, exit status, name.
Lists are compared with each other and stored nowhere: a list of the past is no reference for a test.

Before a change::

    python tests/safety_net.py .venv/bin /tmp/before

after it::

    python tests/safety_net.py .venv/bin /tmp/after
    python tests/safety_net.py --compare /tmp/before /tmp/after

``--figures A B`` prints a table of every figure that moved, of all outputs that hold rows, whatever the form of these
(``results.json`` of schema 1 has names and conditions as text, schema 2 has fields)::

    python tests/safety_net.py --figures /tmp/before /tmp/after

``--quick`` runs the campaigns of three rigs only; ``--only WORD`` compares or calls only what has the word in its name.
The code that runs is what ``BIN/python`` imports (PYTHONPATH goes before what is installed). Commands are called in
forks of one warm process, campaigns as the program itself. Outputs stand in OUT, so that two of them can be set side
by side: ``--compare`` shows where the first line differs.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import Any

EXAMPLES = ("npsat2011", "reinel1969", "sams1996")
RIGS = ("rate_table", "sams_tsh", "sams_tsh_model", "npsat1", "still_gyro", "mesa", "hand_held", "six_faces")
QUICK = ("npsat2011", "sams1996", "reinel1969", "rate_table", "still_gyro", "sams_tsh")
LIST = "hashes.txt"
PRINTED = "printed"
MADE = re.compile(rb'"made": "[^"]*"')  # when provenance.json was written
SETTINGS = {"OMP_NUM_THREADS": "1", "COLUMNS": "120", "NO_COLOR": "1", "TERM": "dumb", "TZ": "UTC", "LC_ALL": "C.UTF-8"}
FILL = "fill "  # a folder: what ``init`` wrote, to be run
FILLED = (
    ('""  # FILL IN', '"1"'),
    ("  # FILL IN", ""),
    ('"reverse" = "? deg"', '"reverse" = "180 deg"'),
    ("? deg", "0 deg"),
    ('["table2"]\nplan = { axis = "x" }', '["table2"]\nplan = { axis = "y" }'),
)
BOTH = " [--json]"  # at the end of a command: it is called with --json too

COMMANDS = Path(__file__).with_name("safety_net_commands.txt")
OTHERS = (  # recordings of others, if the folder with them is there (INERTIALCAL_SHARED)
    "noise/l3g_gyro_x/gyro2_x.txt",
    "noise/allantools_reference/Cs5071A/5071A_phase.txt.gz",
    "noise/allantools_reference/ocxo/ocxo_frequency.txt",
    "imu_tk_xsens_mti/xsens_acc.mat",
    "imu_tk_xsens_mti/xsens_gyro.mat",
    "imucal_ferraris/annotated_session.csv",
    "pims_pad/2014_10_22_09_36_36.324-2014_10_22_09_37_35.317.121f03006",
    "pims_pad/2014_10_22_09_36_36.324-2014_10_22_09_37_35.317.121f03006.header",
    "sunsided_mpu6050_static/set-1__rotate-360ccw-around-x-pointing-forward/mpu6050_accelerometer.mat",
    "sunsided_mpu6050_static/set-1__rotate-360ccw-around-x-pointing-forward/mpu6050_gyroscope.mat",
    "sunsided_mpu6050_static/set-1__rotate-360ccw-around-x-pointing-forward/mpu6050_temperature.mat",
    "tofupilot_thermal/imu_raw_data.csv",
)
FOR_INIT = {
    "init_rate_table": ("made/rates_x1.csv", "made/rates_y1.csv"),
    "init_still_gyro": ("made/still_1.csv", "made/still_2.csv"),
    "init_sams1996": ("example_sams1996/table03_semiprocessed.csv",),
    "init_sams_tsh/recordings": ("rig_sams_tsh/recordings/flip.csv",),
    "init_mesa": ("rig_mesa/recordings/run1.csv", "rig_mesa/recordings/null1.csv"),
    "init_hand_held": ("made/imu_1.csv", "made/imu_2.csv"),
    "init_six_faces": ("made/faces.csv",),
    "init_thermal": ("made/thermal_1.csv", "made/thermal_2.csv"),
}
COUNT = 5.0 / 4095.0 / 0.5  # deg/s a count, of the rigs' converter


def main() -> int:
    """Make a list, or compare two."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("paths", nargs=2, type=Path, metavar=("BIN", "OUT"), help="or, to compare, two OUT")
    parser.add_argument("--compare", action="store_true", help="compare two lists")
    parser.add_argument("--figures", action="store_true", help="print the figures that moved between two lists")
    parser.add_argument("--quick", action="store_true", help="campaigns of three rigs only")
    parser.add_argument("--only", default="", help="only commands with this word")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    one, two = given.paths
    if given.serve:
        serve(one, two)
        return 0
    if given.compare:
        return compare(one, two, given.only)
    if given.figures:
        return figures_moved(one, two, given.only)
    two.mkdir(parents=True, exist_ok=True)
    os.environ.update(SETTINGS)
    net(one.resolve(), two.resolve(), given.quick, given.only)
    return 0


def net(folder: Path, out: Path, quick: bool, only: str) -> None:
    """Run everything into a folder that is emptied before, and write the list."""
    begin = time.monotonic()
    for old in out.iterdir():
        shutil.rmtree(old) if old.is_dir() else old.unlink()
    (out / PRINTED).mkdir()
    lines: list[str] = []
    code = "import inertialcal, pathlib; print(pathlib.Path(inertialcal.__file__).parent)"
    package = Path(
        subprocess.run([folder / "python", "-c", code], check=True, capture_output=True, text=True).stdout.strip()
    )
    campaigns(folder, package, out, quick, lines)
    made(out)
    asked = [one for one in wanted(quick) if only in one]
    jobs = out / "jobs.json"
    jobs.write_text(json.dumps(asked), encoding="utf-8")
    subprocess.run([folder / "python", __file__, "--serve", jobs, out / "served.json"], cwd=out, check=True)
    for job, status in zip(asked, json.loads((out / "served.json").read_text(encoding="utf-8")), strict=True):
        words = job.partition(" ! ")[0]
        lines.extend(printed(out, words, status))
        lines.extend(line for name in job.partition(" ! ")[2].split() for line in written(out, name, after=words))
    (out / LIST).write_text(
        "".join(f"{line}\n" for line in sorted(lines, key=lambda one: one.split(" ", 2)[2])), encoding="utf-8"
    )
    print(f"{len(lines)} outputs in {time.monotonic() - begin:.0f} s: {out / LIST}")


# Campaigns


def campaigns(folder: Path, package: Path, out: Path, quick: bool, lines: list[str]) -> None:
    """Copy examples and simulate rigs, and run those that are asked for by the program itself."""
    program = folder / "inertialcal"
    for name in EXAMPLES + RIGS:
        place = f"example_{name}" if name in EXAMPLES else f"rig_{name}"
        if name in EXAMPLES:
            ignore = shutil.ignore_patterns("out", "__pycache__", "__init__.py")
            shutil.copytree(package / "examples" / name, out / place, ignore=ignore)
        else:
            called(program, out, f"simulate {name} -o {place} --seed 1 --json", lines)
            lines.extend(written(out, place, after=""))
        if not quick or name in QUICK:
            called(program, out, f"run {place} --json", lines)
            lines.extend(written(out, f"{place}/out", after=""))
    noise = out / "still_noise.json"
    words = "allan rig_still_gyro/recordings/still1.csv --unit x=ug --column x --json"
    status = called(program, out, words, lines)
    shutil.copyfile(out / place_of(words, "out"), noise)
    assert status == 0, "no noise for a plan"


def called(program: Path, out: Path, words: str, lines: list[str]) -> int:
    """Call the program itself in a folder, add what it printed, and return its exit status."""
    with (out / place_of(words, "out")).open("wb") as told, (out / place_of(words, "err")).open("wb") as messages:
        left = subprocess.run([program, *shlex.split(words)], cwd=out, stdout=told, stderr=messages, check=False)
    lines.extend(printed(out, words, left.returncode))
    return left.returncode


# Files that commands read


def made(out: Path) -> None:
    """Write files in physical units from the rigs' codes, and folders for ``init``."""
    (out / "made").mkdir()
    (out / "others").mkdir()
    shared = Path(os.environ.get("INERTIALCAL_SHARED", Path(__file__).resolve().parents[2] / "shared")) / "data"
    for name in OTHERS:
        if (shared / name).is_file():
            shutil.copy(shared / name, out / "others")
    for run in "123":
        temperatures = {f"t_{axis}": (f"{axis}_temp", 5.0 / 4095.0 / 0.0264, 6.0) for axis in "xyz"}
        columns = {f"gyro_{axis}": (axis, COUNT, -5.0) for axis in "xyz"} | temperatures
        units = dict.fromkeys(columns, "deg/s") | dict.fromkeys(temperatures, "degC")
        copied(out / f"rig_npsat1/recordings/ambient_{run}.csv", out / f"made/thermal_{run}.csv", columns, units)
    for axis in "xy":
        inverted = {f"gyro_{axis}": (axis, -COUNT, 5.0) for axis in "xz"}  # as they are mounted
        columns = {"rate": ("rate_dps", 1.0, 0.0), "gyro_y": ("y", COUNT, -5.0)} | inverted
        source, target = out / f"rig_rate_table/recordings/{axis}_run1.csv", out / f"made/rates_{axis}1.csv"
        copied(source, target, columns, dict.fromkeys(columns, "deg/s"))
    for run in "12":
        columns = {f"gyro_{axis}": (axis, 1.0, 0.0) for axis in "xyz"}
        source, target = out / f"rig_still_gyro/recordings/still{run}.csv", out / f"made/still_{run}.csv"
        copied(source, target, columns, dict.fromkeys(columns, "deg/s"))
        both: dict[str, str] = {}
        source = out / f"rig_hand_held/recordings/hand{run}.csv"
        for sensor, unit in (("acc", "m/s^2"), ("gyro", "rad/s")):
            columns = {f"{sensor}_{axis}": (f"{sensor}_{axis}", 1.0, 0.0) for axis in "xyz"}
            copied(source, out / f"made/{sensor}{run}.csv", columns, dict.fromkeys(columns, unit))
            both |= dict.fromkeys(columns, unit)
        copied(source, out / f"made/imu_{run}.csv", {name: (name, 1.0, 0.0) for name in both}, both)
    faces(out / "rig_six_faces", out / "made/faces.csv")
    for folder, files in FOR_INIT.items():
        (out / folder).mkdir(parents=True)
        for file in files:
            shutil.copy(out / file, out / folder)


def copied(source: Path, target: Path, columns: dict[str, tuple[str, float, float]], units: dict[str, str]) -> None:
    """Write columns of a file with a factor and an offset, their units in the header."""
    with source.open(newline="", encoding="utf-8") as lines, target.open("w", encoding="utf-8") as to:
        to.write(",".join(["unix_s", *(f"{name} [{units[name]}]" for name in columns)]) + "\n")
        for row in csv.DictReader(lines):
            values = (f"{float(row[name] or 'nan') * factor + offset:.6f}" for name, factor, offset in columns.values())
            to.write(",".join([row["unix_s"], *values]) + "\n")


def faces(rig: Path, target: Path) -> None:
    """Write a table, a row a position: means of the first six sections of a protocol."""
    with (rig / "protocols/hand1.csv").open(newline="", encoding="utf-8") as lines:
        sections = [(row["section"], int(row["start"]), int(row["end"])) for row in csv.DictReader(lines)][:6]
    with (rig / "recordings/hand1.csv").open(newline="", encoding="utf-8") as lines:
        rows = [[float(row[f"acc_{axis}"]) for axis in "xyz"] for row in csv.DictReader(lines)]
    with target.open("w", encoding="utf-8") as to:
        to.write("position,acc_x [m/s^2],acc_y [m/s^2],acc_z [m/s^2]\n")
        for name, start, end in sections:
            means = [math.fsum(axis) / (end - start) for axis in zip(*rows[start:end], strict=True)]
            to.write(",".join([name, *(f"{mean:.7f}" for mean in means)]) + "\n")


# Commands


def wanted(quick: bool) -> list[str]:
    """Return the commands, those with [--json] twice; quick: once, and without those on campaigns that did not run."""
    found: list[str] = []
    left_out = False
    for line in COMMANDS.read_text(encoding="utf-8").splitlines():
        if line.startswith(">"):
            left_out = quick and line.startswith("> after")
        elif line and not line.startswith("#") and not left_out:
            words, _, files = line.partition(" ! ")
            files = f" ! {files}" if files else ""
            if words.endswith(BOTH):
                words = words.removesuffix(BOTH)
                found.extend([words + " --json" + files] if quick else [words + files, words + " --json" + files])
            else:
                found.append(words + files)
    twice = {one for one in found if found.count(one) > 1}
    return [one for number, one in enumerate(found) if one not in twice or found.index(one) == number]


def serve(jobs: Path, served: Path) -> None:
    """Call the commands of a list, each in a fork of this process, in which everything is imported once."""
    import gc
    import importlib
    import pkgutil

    import inertialcal

    for module in pkgutil.walk_packages(inertialcal.__path__, "inertialcal."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    gc.collect()
    gc.freeze()
    left = []
    for job in json.loads(jobs.read_text(encoding="utf-8")):
        words = job.partition(" ! ")[0]
        if words.startswith(FILL):
            words = filled(Path(words.removeprefix(FILL)) / "campaign.toml")
        name = job.partition(" ! ")[0]
        left.append(forked(shlex.split(words), Path(place_of(name, "out")), Path(place_of(name, "err"))))
    served.write_text(json.dumps(left), encoding="utf-8")


def filled(path: Path) -> str:
    """Fill a campaign of ``init`` in, and return the command that looks at it."""
    if path.is_file():
        text = path.read_text(encoding="utf-8")
        for old, new in FILLED:
            text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")
    return f"check {path.parent} --json"


def forked(words: list[str], out: Path, messages: Path) -> int:
    """Call a command in a fork, its outputs into two files; return its exit status."""
    from inertialcal.cli.__main__ import main as command

    sys.stdout.flush()
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    status = 99
    try:
        for number, file in ((1, out), (2, messages)):
            opened = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(opened, number)
        command(words)
    except SystemExit as left:
        status = int(left.code or 0)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


# The list


def place_of(words: str, ending: str) -> str:
    """Return the file in which an output of a command is kept."""
    return f"{PRINTED}/{hashlib.sha256(words.encode()).hexdigest()[:16]}.{ending}"


def printed(out: Path, words: str, status: int) -> Iterator[str]:
    """Return the lines of what a command printed; an internal error is told at once."""
    if status not in (0, 1, 2, 3, 4):
        print(f"exit {status}: {words}", file=sys.stderr)
    for ending in ("out", "err"):
        yield line_of(out / place_of(words, ending), f"{words} [{ending}]", str(status))


def written(out: Path, name: str, after: str) -> Iterator[str]:
    """Return the lines of a file, or of all files in a folder, that a command wrote."""
    place = out / name
    named = sorted(one for one in place.rglob("*") if one.is_file()) if place.is_dir() else [place]
    files = [one for one in named if one.name != "SHA256SUMS"]  # of these files, one of which says when
    suffix = f" < {after}" if after else ""
    for file in files:
        yield line_of(file, f"{file.relative_to(out)}{suffix}", "-")


def line_of(file: Path, name: str, status: str) -> str:
    """Return hash, exit status and name; the time at which it was written does not count."""
    content = file.read_bytes() if file.is_file() else b"(no such file)"
    return f"{hashlib.sha256(MADE.sub(b'', content)).hexdigest()} {status} {name}"


def compare(one: Path, two: Path, only: str) -> int:
    """Print what differs between two lists; names that only one has count unless one is of a quick run."""
    folders = [path if path.is_dir() else path.parent for path in (one, two)]
    lists = [listed(folder / LIST) for folder in folders]
    names = [name for name in sorted(lists[0].keys() & lists[1].keys()) if only in name]
    differing = [name for name in names if lists[0][name] != lists[1][name]]
    for name in differing:
        print(f"DIFFERS {name}")
        print("".join(f"    {line}\n" for line in first_difference(folders, name, lists)), end="")
    missing = sorted(name for name in lists[0].keys() - lists[1].keys() if only in name)
    added = sorted(name for name in lists[1].keys() - lists[0].keys() if only in name)
    for word, some in (("only in the first", missing), ("only in the second", added)):
        print(f"{len(some)} {word}" + "".join(f"\n    {name}" for name in some[:5])) if some else None
    print(f"{len(names)} compared, {len(differing)} differ")
    return 1 if differing else 0


def listed(path: Path) -> dict[str, tuple[str, str]]:
    """Return hash and exit status by name."""
    rows = (line.split(" ", 2) for line in path.read_text(encoding="utf-8").splitlines())
    return {name: (digest, status) for digest, status, name in rows}


def kept(name: str) -> str:
    """Return the file in which the output of a line is kept."""
    words, bracket, ending = name.rpartition(" [")
    return place_of(words, ending.rstrip("]")) if bracket else name.partition(" < ")[0]


def first_difference(folders: list[Path], name: str, lists: list[dict[str, tuple[str, str]]]) -> list[str]:
    """Return where two outputs part, if both are kept."""
    statuses = [one[name][1] for one in lists]
    said = [] if statuses[0] == statuses[1] else [f"exit {statuses[0]} -> {statuses[1]}"]
    files = [folder / kept(name) for folder in folders]
    if not all(file.is_file() for file in files):
        return said
    texts = [file.read_text(encoding="utf-8", errors="replace") for file in files]
    at = next((n for n, (a, b) in enumerate(zip(*texts, strict=False)) if a != b), min(map(len, texts)))
    begin = max(0, at - 60)
    return [*said, *(f"{sign} {text[begin : at + 100]!r}" for sign, text in zip("-+", texts, strict=True))]


# Figures

Figure = tuple[Any, ...]  # value, u, ends of the interval, degrees of freedom, unit
SAME = 1e-9  # relative: below it a figure has moved by rounding


def figures_moved(one: Path, two: Path, only: str) -> int:
    """Print every figure that differs between two folders of outputs; return 1 if there is one."""
    names = [listed(path / LIST) for path in (one, two)]
    counted, rounding, lines = 0, 0, []
    for name in sorted(names[0].keys() & names[1].keys()):
        place = kept(name)
        if only not in name or place.endswith(".err") or not (place.startswith(PRINTED) or "results.json" in place):
            continue
        before, after = (rows_of(path / place) for path in (one, two))
        if before is None or after is None:
            continue
        counted += sum(map(len, after.values()))
        for figure in [*before, *(figure for figure in after if figure not in before)]:
            old, new = before.get(figure, []), after.get(figure, [])
            for a, b in zip_longest([x for x in old if x not in new], [x for x in new if x not in old]):
                if a and b and a[-1] == b[-1] and all(map(near, a[:-1], b[:-1])):
                    rounding += 1
                else:
                    lines.append(f"| {name} | {' '.join(figure)} | {shown(a)} | {shown(b)} |")
    print("| output | figure | before | after |\n|---|---|---|---|" if lines else "no figure moved")
    print("\n".join(lines))
    print(f"\n{counted} figures compared, {len(lines)} moved, {rounding} by less than {SAME:g} relative")
    return 1 if lines else 0


def rows_of(path: Path) -> dict[tuple[str, ...], list[Figure]] | None:
    """Return the figures of an output by test, name, axis and case; None where it holds no rows."""
    try:
        rows = json.loads(path.read_text(encoding="utf-8"))["results"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    found: dict[tuple[str, ...], list[Figure]] = {}
    for row in rows:
        if isinstance(row, dict) and "quantity" in row and "value" in row:
            ends = row.get("interval") or {}
            numbers = (row["value"], row.get("u"), ends.get("lo"), ends.get("hi"), row.get("dof"), row.get("unit"))
            found.setdefault(name_of(row), []).append(numbers)
    return found


def name_of(row: dict[str, Any]) -> tuple[str, ...]:
    """Return what a row is, in words that both forms have."""
    name, case = row["quantity"], row.get("condition") or ""
    if "method" in row:  # schema 2
        at, member, power = row["at"], row["member"], row["power"]
        line = at is not None and at["what"] == "line"
        if (power or name == "bias_voltage") and not line:
            name = f"{name}_{power}"
        number = "" if at is None else f"{at['value']:.{4 if line else 6}g} {at['unit']}".rstrip()
        place = f"line at {f'{power} x ' if power else ''}{number}" if line else number
        labels = {"flip": "flip {}", "run": "run {} alone", "held_out": "held out, {}"}
        part = "" if member is None else labels.get(member["kind"], "{}").format(member["label"]).removesuffix(", ")
        method = "" if row["method"] == "result" else row["method"]
        parts = [place, part] if line else [method, part, place]
        case = ", ".join(one for one in parts if one) or row["sensor"] or case
    return row.get("test") or "", name, row.get("axis") or "", case


def near(a: Any, b: Any) -> bool:
    """Whether two numbers are the same but for rounding."""
    if a is None or b is None:
        return a is b
    return math.isclose(a, b, rel_tol=SAME, abs_tol=0.0)


def shown(figure: Figure | None) -> str:
    """Return a figure as the table has it."""
    if figure is None:
        return "-"
    return f"{' ± '.join('-' if one is None else f'{one:.6g}' for one in figure[:2])} {figure[-1] or ''}".strip()


if __name__ == "__main__":
    sys.exit(main())
