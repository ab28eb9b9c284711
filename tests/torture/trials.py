"""A trial: one command on a few files, some of them mutated; all follows from its number."""

from __future__ import annotations

import hashlib
import json
import random
import re
import shlex
import shutil
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from forked import Process, Ran
from mutations import NAMES, NUMBERS, UNITS, Level, mutated_bytes, mutated_file, mutated_table, mutated_text, sealed
from seed_files import BINARY, TEXT, numbers, read_csv
from special_inputs import Check, no_more, specials

from inertialcal.campaign.twins.twin import TRUTH

RECORDINGS = """
info {still}
info {held} --unit acc=m/s2 --unit gyro=rad/s
info {thermal1} {rates}
info {flip} --unit x=ug
allan {still} --unit x=deg/s --unit y=deg/s --unit z=deg/s
allan {still} --unit x=deg/s --column x --deviation overlapping_hadamard --taus decade
allan {still} --unit y=deg/s --column y --for kalibr --for px4 --warm-up "1 min"
psd {still} --unit x=deg/s --column x
psd {still} --unit z=deg/s --column z --spectrum multitaper --averaging "1 s"
sine {mass1} --column pulses --period "480 s"
sine {mass1} --column pulses --schedule schedule.csv
thermal {thermal1} {thermal2} --unit gyro=deg/s --unit t_x=degC --unit t_y=degC --unit t_z=degC
thermal {thermal1} --order 1 --unit gyro_x=deg/s --unit t_x=degC --column x=gyro_x --column temperature=t_x
thermal {thermal1} --one-run --column "x=gyro_x [deg/s]" --column "temperature=t_x [degC]" --at "0 degC"
rate-table {rates} --axis y --unit rate=deg/s --unit gyro=deg/s
rate-table {rates} --axis y --zero-reference --range "6 deg/s" --unit rate=deg/s --unit gyro=deg/s
flip {flip} --unit ug --column x=x --column y=y --column z=z
flip {flip} --unit ug --column x=x --column y=y --column z=z --angle "180 deg" --corrected
positions {held} --unit acc=m/s2 --unit gyro=rad/s --gravity "9.807 m/s2"
positions acc={held} --unit acc=m/s2 --gravity "9.807 m/s2" --shortest "2 s"
positions {faces} --unit acc=m/s2 --gravity "9.807 m/s2"
mass-attraction {mass1} {null1} --null null1 --schedule schedule.csv --column x=pulses --gate "100 s"
mass-attraction {mass1} --schedule schedule.csv --column x=pulses --gate "100 s" --column tilt=tilt_rad --tilt known
convert {still} made.npz --unit x=deg/s
convert {held} made.parquet --unit acc=m/s2
convert {thermal1} made.csv --unit t_x=degC
compensate model.json {thermal1} -o made.csv --temperature t_x --unit gyro=deg/s --unit t_x=degC
compensate acc.json {held} -o made.parquet --unit acc=m/s2 --unit gyro=rad/s
compensate model.json {rates} -o made.npz --temperature "25 degC" --uncertainty --unit gyro=deg/s
allan {still} --unit x=deg/s --column x -o made.svg
"""
CAMPAIGNS = ("rate_table", "still_gyro", "mesa", "hand_held", "six_faces", "sams_tsh", "sams_tsh_model", "npsat1")
CAMPAIGN = """
check rig_{rig}
run rig_{rig}
check example_npsat2011
check example_reinel1969
check example_sams1996
run rig_{rig}
run example_npsat2011
run example_reinel1969
run example_sams1996
score rig_{rig}
init rig_{rig}/recordings
"""
RESULTS = """
show rig_{rig}
show rig_{rig}/out
show rig_{rig}/out/results.json
show rig_rate_table/out --figure rate_error -o made.svg
show rig_still_gyro/out --figure allan -o made.svg
show rig_hand_held/out/model.json
compare rig_{rig} rig_{rig}
compare rig_{rig}/out/results.json example_npsat2011/out/results.json
compare rig_{rig}/out rig_{rig}/out --allowed "0.1 %"
compare rig_{rig}/out rig_{rig}/out --allowed "0.1 %" --decision guard_factor=1
budget rig_{rig}
budget rig_{rig}/out/results.json --wanted bias="1 mg" --test model
score rig_{rig}
export rig_rate_table --to c -o made.h --unjudged
"""
MODELS = """
show model.json
show gyro.json
show acc.json -o made.svg
export model.json --to c -o made.h --unjudged
export model.json --to python -o made.py --unjudged
export model.json --to json -o made.json --unjudged
export acc.json --to imucal --with gyro.json -o made.json --unjudged
export acc.json --to kalibr-model --with gyro.json -o made.yaml --unjudged
export acc.json --to imu-tk -o made.txt --unjudged
export gyro.json --to realsense --with acc.json -o made.json --unjudged
compare model.json model.json
compare acc.json gyro.json
compare gyro.json rig_hand_held --allowed "0.1 %"
compensate model.json thermal1.csv -o made.csv --temperature t_x --unit gyro=deg/s
compensate acc.json held.csv -o made.parquet --unit acc=m/s2 --unit gyro=rad/s --uncertainty
compensate gyro.json held.csv -o made.csv --unit acc=m/s2 --unit gyro=rad/s
"""
OTHERS = """
show imucal.json#acc
show kalibr-model.yaml#gyro
show imu-tk.txt
show realsense.json#acc
export imucal.json#gyro --to c -o made.h --unjudged
export kalibr-model.yaml#acc --to json -o made.json --unjudged
export realsense.json#gyro --to imu-tk -o made.txt --unjudged
compare imucal.json#acc acc.json
compare kalibr-model.yaml#gyro realsense.json#gyro
compensate imucal.json#acc held.csv -o made.csv --unit acc=m/s2 --unit gyro=rad/s
compensate imu-tk.txt held.csv -o made.csv --unit acc=m/s2 --unit gyro=rad/s
"""
PLANS = """
plan mass-attraction moved.toml
plan mass-attraction moved.toml --schedule made.csv
plan mass-attraction moved.toml --set noise.file=noise.json --set noise.axis=x
plan mass-attraction moved.toml --set "body.cube=10 cm" --set body.count=50 -o made.svg --figure forecast
"""
CARDS = """
programme-1969 deck.cards
programme-1969 deck.cards -o made
info deck.cards
sine deck.cards --period "400 s" --sample-rate 0.01
allan deck.cards --sample-rate 0.01
"""
PAD = """
info record.121f03
allan record.121f03
psd record.121f03 --frame sensor
flip record.121f03
convert record.121f03 made.csv --frame sensor
convert record.121f03 made.parquet
"""
OPTIONS = """
plan positions --scatter "0.2 mg" --have faces --target bias="0.15 mg" --gravity-u "0.1 mg"
plan positions --scatter "0.2 mg" --have faces --gravity-u "0.1 mg" --next 3
plan mass-attraction --set "body.cube=10 cm" --set "body.mass=500 kg" --set "body.stand_off=7.6 cm" --set "motion.stroke=10 cm, 40 cm" --set timing.drive=abab
plan mass-attraction --set "orbit.stand_off=10 cm" --set "orbit.acceleration=1e-10 g"
simulate still_gyro -o made --seed 3 --fault knocked
init given
show model.json --axis x
"""  # noqa: E501 - commands on one line


@dataclass(frozen=True)
class Kind:
    """Commands on one kind of input, and how often they are tried."""

    name: str
    commands: tuple[str, ...]
    weight: float
    formats: tuple[str, ...] = (".csv",)
    levels: tuple[Level, ...] = ("bytes", "numbers", "structure")
    targets: str = ".*"  # of the files copied, those that may be mutated


def _lines(text: str) -> tuple[str, ...]:
    return tuple(line for line in text.splitlines() if line)


KINDS = (
    Kind("recordings as text", _lines(RECORDINGS), 0.24, tuple(TEXT), targets=r"(?!model|acc\.json)"),
    Kind("recordings, binary", _lines(RECORDINGS), 0.22, tuple(BINARY), targets=r"(?!model|acc\.json)"),
    Kind("card images", _lines(CARDS), 0.03),
    Kind("PAD pairs", _lines(PAD), 0.05),
    Kind("campaigns", _lines(CAMPAIGN), 0.14, targets=r"(?!.*/out/)"),
    Kind("results", _lines(RESULTS), 0.10, targets=r".*/out/(?!report|provenance|verdicts|results\.csv)"),
    Kind("models", _lines(MODELS), 0.08, targets=r".*(model|acc|gyro)[a-z_]*\.json"),
    Kind("models of others", _lines(OTHERS), 0.05, targets=r"(imu|kalibr|realsense)"),
    Kind("settings of plans", _lines(PLANS), 0.04, targets=r"moved|noise"),
    Kind("options", _lines(RECORDINGS + OPTIONS + CARDS + PAD + MODELS), 0.05, levels=("numbers", "structure")),
)
LEVELS = {"bytes": 0.15, "numbers": 0.5, "structure": 0.35}
WRITES = {"-o", "--output", "--schedule", "--campaign"}


@dataclass(frozen=True)
class Trial:
    """A command, its class, and what it may write."""

    number: int
    label: str
    words: tuple[str, ...]
    outputs: tuple[str, ...]  # paths that it may make or change, with all that is in them
    check: Check = no_more
    process: Process | None = None


def trial(number: int, seeds: Path, folder: Path) -> Trial:
    """Return a trial, its files written into a folder."""
    rng = random.Random(f"inertialcal torture {number}")
    kind = rng.choices(KINDS, [one.weight for one in KINDS])[0]
    level: Level = rng.choices(kind.levels, [LEVELS[one] for one in kind.levels])[0]
    line = rng.choice(kind.commands).replace("{rig}", rng.choice(CAMPAIGNS))
    tables = re.findall(r"\{(\w+)\}", line)
    endings = {name: rng.choice(kind.formats) for name in tables}
    for name, ending in endings.items():
        line = line.replace(f"{{{name}}}", f"{name}{ending}")
    words = shlex.split(line)
    outputs = tuple(written(words))
    copied = [name for word in words for name in names_of(word, seeds) if name not in outputs]
    places = [f"{name}{ending}" for name, ending in endings.items()]
    for name in copied:
        _copy(seeds / name, folder / name)
    if words[0] == "init" and not copied:
        for name in rng.sample(("still", "thermal1", "rates", "held", "mass1", "faces"), 2):
            _copy(seeds / f"{name}.csv", folder / "given" / f"{name}.csv")
        outputs = (*outputs, "given/campaign.toml")
    for (name, ending), place in zip(endings.items(), places, strict=True):
        _table(seeds / f"{name}.csv", folder / place, ending, level, rng, name == tables[0] and kind.name != "options")
    if kind.name == "options":
        words = _mutated_options(words, level, rng)
    else:
        _mutate_files(folder, {*places}, kind, level, rng)
    words += ["--json"] * (rng.random() < 0.5) + ["--quiet"] * (rng.random() < 0.1)
    return Trial(number, f"{kind.name}: {level}", tuple(words), outputs)


FIXED = tuple(specials())


def fixed(number: int, seeds: Path, folder: Path) -> Trial:
    """Return a special input by its number, which is negative, its files written into a folder."""
    special = FIXED[-number - 1]
    words = shlex.split(special.line)
    for name in [*special.needs, *(name for word in words for name in names_of(word, seeds))]:
        _copy(seeds / name, folder / name)
    special.prepare(folder)

    def check(folder: Path, end: Ran) -> list[str]:
        right = [] if end.status in special.statuses else [f"exit {end.status}, not {sorted(special.statuses)}"]
        return [*right, *special.check(folder, end)]

    return Trial(number, special.name, tuple(words), special.outputs, check, special.process)


def written(words: Sequence[str]) -> list[str]:
    """Return what a command may write."""
    found = [second for first, second in pairwise(words) if first in WRITES]
    if words[0] == "convert":
        found.append(words[2])
    if words[0] == "run":
        found += [f"{words[1]}/out", f"{words[1]}/out-cache"]
    if words[0] == "init":
        found.append(f"{words[1]}/campaign.toml")
    return found


def names_of(word: str, seeds: Path) -> list[str]:
    """Return what of the seeds a word names: a file with its header, the top folder of a path."""
    name = word.rsplit("=", maxsplit=1)[-1].split("#", maxsplit=1)[0]
    top = name.split("/")[0]
    if not top or not re.fullmatch(r"[\w./-]+", name) or top.startswith(".") or not (seeds / top).exists():
        return []
    return [top, *([f"{top}.header"] if (seeds / f"{top}.header").exists() else [])]


def _copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    if source.is_dir():
        shutil.copytree(source, target, dirs_exist_ok=True)
    else:
        shutil.copy(source, target)


def _table(source: Path, target: Path, ending: str, level: Level, rng: random.Random, change: bool) -> None:
    """Write a table in a format, changed or as it is; what its library does not write is written unchanged."""
    table = read_csv(source.read_text(encoding="utf-8"))
    write = BINARY[ending] if ending in BINARY else TEXT[ending]
    binary = ending in BINARY
    table = numbers(table) if binary else table
    try:
        write(target, mutated_table(table, level, rng, binary) if change and level != "bytes" else table)
    except Exception:
        write(target, table)
    if change and level == "bytes":
        target.write_bytes(mutated_bytes(target.read_bytes(), rng))


def _mutate_files(folder: Path, already: set[str], kind: Kind, level: Level, rng: random.Random) -> None:
    """Change one or two of the files that were copied; none where a table was changed as it was written."""
    names = sorted(str(one.relative_to(folder)) for one in folder.rglob("*") if one.is_file())
    open_to = [name for name in names if name not in already and re.match(kind.targets, name)]
    first = [name for name in open_to if name.endswith(("campaign.toml", "results.json"))]
    if already and (rng.random() < 0.8 or not open_to):
        return
    for _ in range(rng.randint(1, 2) if open_to else 0):
        name = rng.choice(first if first and rng.random() < 0.4 else open_to)
        path = folder / name
        if name.endswith("121f03") and level != "bytes":
            path.write_bytes(_mutated_floats(path.read_bytes(), level, rng))
        else:
            path.write_bytes(mutated_file(path.read_bytes(), name, level, rng))
        if name.endswith(TRUTH) and level != "bytes":
            _reseal(folder / name.removesuffix(f"/{TRUTH}") / "campaign.toml", path, r"[0-9a-f]{64}")
        elif name.endswith("curves.parquet") and level != "bytes":
            _reseal(path.with_name("results.json"), path, r'(?<="curves_sha256": ")[0-9a-f]{64}')


def _mutated_floats(content: bytes, level: Level, rng: random.Random) -> bytes:
    table = np.frombuffer(content[: len(content) // 16 * 16], "<f4").reshape(-1, 4).astype(float)
    new: dict[str, Any] = mutated_table({str(i): table[:, i] for i in range(4)}, level, rng)
    columns = [column for column in new.values() if column.dtype != object]
    if len({len(column) for column in columns}) != 1:
        return mutated_bytes(content, rng)
    with np.errstate(all="ignore"):
        return np.column_stack(columns).astype("<f4").tobytes()


def _reseal(names: Path, changed: Path, form: str) -> None:
    """Put the hash of a changed file into the one that names it, as if it had been written so."""
    text = names.read_text(encoding="utf-8", errors="surrogateescape")
    new = re.sub(form, hashlib.sha256(changed.read_bytes()).hexdigest(), text)
    with suppress(ValueError):  # it may be changed too, and no longer be JSON
        new = json.dumps(sealed(json.loads(new)), indent=1)
    names.write_text(new, encoding="utf-8", errors="surrogateescape")


def _mutated_options(words: list[str], level: Level, rng: random.Random) -> list[str]:
    """Change the values of options, or repeat, drop and swap words; what it may write keeps its place."""
    kept = {*WRITES, *written(words)}
    for _ in range(rng.randint(1, 2)):
        places = [at for at, word in enumerate(words) if at and word not in kept and words[at - 1] not in WRITES]
        at = rng.choice(places)
        if level == "numbers":
            new = (
                mutated_text(words[at], rng).strip() if re.search(r"\d", words[at]) else rng.choice((*NUMBERS, *UNITS))
            )
            name, equals, _ = words[at].partition("=")
            words[at] = f"{name}={rng.choice(NUMBERS)} {rng.choice(UNITS)}" if equals and rng.random() < 0.5 else new
        elif rng.random() < 0.5:
            words[at] = rng.choice(NAMES)
        else:
            words.insert(at, words[at])
    return words
