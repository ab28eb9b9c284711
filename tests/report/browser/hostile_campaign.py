"""A campaign whose every free text is given from outside: each Text of the schema is found by walking it.

A field that is added to the schema is filled without a word here; a table that is added must be put into `document`.
"""

from __future__ import annotations

import json
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from pydantic import BaseModel

from inertialcal.campaign.file.schema import CampaignFile
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import Key
from inertialcal.core.schema.quantities import Text
from inertialcal.files.models.model_json import dump_model
from inertialcal.procedures.mass_attraction.reduction import repeated
from inertialcal.procedures.mass_attraction.schedule_csv import write_schedule
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.sensor_model import SensorModel

Give = Callable[[str], str]  # from the name of a field ("Item.maker") to its text
Keys = tuple[str | int, ...]

# Texts that are read as something else: a grammar.
NOT_FREE = {"Requirement.where"}
# Texts that stand in place of others: a model in a file, instead of `ground`; stated conditions, instead of those that
# tests name freely.
INSTEAD = {"Chain.model", "Condition.text"}
# And positions of a head by a table, instead of a list.
INSTEAD |= {f"Dwells.{name}" for name in ("file", "start", "stop", "angle", "dwell", "flip")}
# And the elements of an orbit, instead of recorded positions.
INSTEAD |= {"Tle.file", "Tle.satellite"}
FILES = {
    "RecordingEntry.file": ".parquet",
    "RecordingEntry.sections": ".json",
    "Schedule.file": ".parquet",
    "MovedMass.schedule": ".csv",
    "Turned.schedule": ".parquet",
    "Head.file": ".toml",
    "KnownDrive.schedule": ".csv",
    "RecordingEntry.profile": ".csv",
    "RecordingEntry.curve": ".csv",
    "Flips.file": ".json",
}
CIRCLED = 432  # gates of a run of a turned mass
LONGEST_NAME = 120  # characters of a folder or file name; each is up to 4 of the 255 bytes
RATES = (-4.0, -1.0, 1.0, 4.0, 6.0)  # deg/s; the last is out of range
DWELL = 20  # s
AXES = ("x", "y", "z")
STOOD = 300  # s, a head at each position
ANGLES = ("0 deg", "180 deg")
FACES = ("x+", "x-", "y+", "y-", "z+", "z-")
STEPPED = (0.0, 1.0) * 4  # V, of another channel
LAID = 200  # samples, a unit on each face, twice
MOVED = repeated((0.1, 0.4), (7e-7, 2e-7), cycles=40, dwell=100.0, move=20.0, drive="abab")
HEADS = ("first", "second", "third")  # on one body


def document() -> dict[str, Any]:
    """Return a campaign with every table that the schema knows, its texts not yet filled."""
    plan = {"axis": "x", "attitude": {"tilt": "-36.4 deg", "u": "3 deg", "azimuth": "0 deg"}}
    return {
        "schema": 2,
        "campaign": {"id": "hostile"},
        "item": {},
        "site": {"latitude": "36.6 deg"},
        "standards": {
            "rate_table": {"rate": {"u": "0.05 %"}, "mounting": {"half_width": "0.1 deg", "dof": 12.0}},
            "converter": {"reference": {"expanded": "0.2 %", "k": 2.0}},
        },
        "conditions": {"air": {}},
        "sensors": {
            "suite": {
                "kind": "gyro",
                "axes": ["x", "y", "z"],
                "unit": "deg/s",
                "range": ["-5 deg/s", "5 deg/s"],
                "chain": {"kind": "none"},
            },
            "head": {
                "kind": "accelerometer",
                "axes": list(AXES),
                "unit": "ug",
                "chain": {
                    "kind": "adc",
                    "lsb": "10 V / 65536",
                    "counts": [-32768, 32767],
                    "gain": 100.0,
                    "scale_factor": "1 V/g",
                    "ground": {"gains": {"100": {"bias": {axis: ["1 ug"] for axis in AXES}}}},
                },
            },
            "mesa": {
                "kind": "accelerometer",
                "axes": ["x"],
                "unit": "g",
                "chain": {"kind": "pulse_rate", "gate": "100 s", "scale_factor": "10.21 count/s/ug"},
            },
            "unit": {"kind": "accelerometer", "axes": list(AXES), "unit": "m/s2", "chain": {"kind": "none"}},
        },
        "recordings": {
            "table": {"sensor": "suite", "rows": {"unit": "deg/s"}},
            "steps": {
                "sensor": "suite",
                "axis": "x",
                "channels": {"x": {"unit": "deg/s"}},
                "clock": {},
                "schedule": {"unit": "deg/s"},
            },
            "stepped": {
                "sensor": "suite",
                "channels": {"x": {"unit": "deg/s"}},
                "clock": {},
                "conditions": {"field": {"unit": "V"}},
            },
            "means": {"sensor": "head", "means": {"unit": "ug", "angles": {}, "half_widths": {"0.95": ""}}},
            "turned": {
                "sensor": "head",
                "channels": {axis: {"unit": "count"} for axis in AXES},
                "clock": {},
                "dwells": {},
                "tle": {},
                "positions": [
                    {"start": i * STOOD, "stop": (i + 1) * STOOD, "angle": angle} for i, angle in enumerate(ANGLES)
                ],
            },
            "lines": {"sensor": "mesa", "lines": {"applied_unit": "ng", "unit": "count/s"}},
            "moved": {
                "sensor": "mesa",
                "channels": {"x": {"unit": "count"}},
                "clock": {},
                "mass": {"begin": 0.5},
            },
            "circled": {
                "sensor": "mesa",
                "channels": {"x": {"unit": "count"}},
                "clock": {},
                "turned": {"begin": 0.5},
            },
            **{
                name: {"sensor": "unit", "channels": {axis: {"unit": "m/s2"} for axis in AXES}, "clock": {}, "head": {}}
                for name in HEADS
            },
            "driven": {
                "sensor": "mesa",
                "channels": {"x": {"unit": "count"}},
                "clock": {},
                "topics": [""],
                "drive": {},
            },
            "laid": {
                "sensor": "unit",
                "channels": {axis: {"unit": "m/s2"} for axis in AXES},
                "clock": {},
                "orientations": list(FACES * 2),
                "sections": "",
            },
            "shaken": {
                "sensor": "unit",
                "axis": "x",
                "channels": {"x": {"unit": "m/s2"}},
                "clock": {},
                "profile": "",
            },
            "flown": {
                "sensor": "unit",
                "channels": {axis: {"unit": "m/s2"} for axis in AXES},
                "clock": {},
                "curve": "",
            },
            "several": {"sensor": "head", "flips": {"unit": "ug"}},
            "rested": {
                "sensor": "unit",
                "rests": {
                    "reading": dict.fromkeys(AXES, ""),
                    "unit": "m/s2",
                    "scatter": dict.fromkeys(AXES, ""),
                    "direction": dict.fromkeys(AXES, ""),
                },
            },
        },
        "tests": [
            {"id": "rows", "procedure": "rate_table", "recordings": ["table"], "groups": [0, 1], "plan": plan},
            {"id": "held", "procedure": "rate_table", "recordings": ["steps"], "use": "hold_out", "plan": plan},
            {"id": "flips", "procedure": "flip", "recordings": ["means"], "plan": {"axis": "x"}, "use": "report_only"},
            {"id": "flip", "procedure": "flip", "recordings": ["turned"], "plan": {"axis": "x"}, "use": "report_only"},
            {
                "id": "stepped",
                "procedure": "sensitivity",
                "recordings": ["stepped"],
                "use": "report_only",
                "plan": {"to": ["field"]},
            },
            {
                "id": "runs",
                "procedure": "mass_attraction",
                "recordings": ["lines"],
                "use": "report_only",
                "plan": {"tilt": "ignored"},
            },
            {
                "id": "mass",
                "procedure": "mass_attraction",
                "recordings": ["moved"],
                "use": "report_only",
                "plan": {"tilt": "ignored"},
            },
            {
                "id": "circle",
                "procedure": "turned_mass",
                "recordings": ["circled"],
                "use": "report_only",
                "plan": {
                    "mass": "4 kg",
                    "radius": "0.2 m",
                    "altitude": "560 km",
                    "satellite": "1000 kg",
                    "recoil": "stated",
                },
            },
            {"id": "body", "procedure": "heads", "recordings": list(HEADS), "use": "report_only"},
            {"id": "drive", "procedure": "sine", "recordings": ["driven"], "use": "report_only"},
            {"id": "laid", "procedure": "positions", "recordings": ["laid"], "use": "report_only"},
            {"id": "rested", "procedure": "positions", "recordings": ["rested"], "use": "report_only"},
            {"id": "flown", "procedure": "microgravity", "recordings": ["flown"], "use": "report_only"},
            {"id": "shifted", "procedure": "shifted_model", "recordings": ["several"], "use": "report_only"},
            {"id": "shaken", "procedure": "vibration", "recordings": ["shaken"], "use": "report_only"},
        ],
        "requirements": [
            {"id": "R1", "quantity": "rate_error", "limit": "5 %"},
            {"id": "R2", "quantity": "bias", "lower": "-1 deg/s", "upper": "1 deg/s"},
            {"id": "R3", "quantity": "scale_factor_error", "limit": "1 %"},
        ],
        "certificate": {"laboratory": {}, "customer": {}, "methods": [""], "signatures": [{}]},
    }


def leaves(model: type[BaseModel] = CampaignFile, at: Keys = (), value: Any = None) -> Iterator[tuple[str, Keys, Any]]:
    """Return (name, keys, type) of each text that the tables of a document have; all tables where none is given."""
    for name, kind in get_type_hints(model, include_extras=True).items():
        if name != "model_config" and name in model.model_fields:
            key = model.model_fields[name].alias or name
            inner = value.get(key) if isinstance(value, dict) else None
            yield from _leaves(kind, f"{model.__name__}.{name}", (*at, key), inner, value is None)


def _leaves(kind: Any, name: str, at: Keys, value: Any, every: bool) -> Iterator[tuple[str, Keys, Any]]:
    origin, arguments = get_origin(kind), get_args(kind)
    if kind is str or (origin is Annotated and arguments[0] is str):
        yield name, at, kind
    elif isinstance(kind, type) and issubclass(kind, BaseModel):
        within = at[:-1].count(at[-1]) > 1 if every and at else False  # a rule inside a rule inside a rule
        if not within and (every or isinstance(value, dict)):
            yield from leaves(kind, at, None if every else value)
    elif origin is Annotated:
        yield from _leaves(arguments[0], name, at, value, every)
    elif origin in (Union, types.UnionType):
        yield from _union(arguments, name, at, value, every)
    elif origin in (list, dict):
        items: Any = {} if value is None else value if isinstance(value, dict) else dict(enumerate(value))
        for key, one in {"*": None}.items() if every else items.items():
            yield from _leaves(arguments[-1], name, (*at, key), one, every)


def _union(kinds: tuple[Any, ...], name: str, at: Keys, value: Any, every: bool) -> Iterator[tuple[str, Keys, Any]]:
    """Take the container where the document has one, else the plain text."""
    for given in kinds:
        limited = get_origin(given) is Annotated and get_origin(get_args(given)[0]) is list  # of a length
        kind = get_args(given)[0] if limited else given
        container = get_origin(kind) in (list, dict) or (isinstance(kind, type) and issubclass(kind, BaseModel))
        if every or container == isinstance(value, (list, dict)):
            yield from _leaves(kind, name, at, value, every)


def filled(give: Give) -> dict[str, Any]:
    """Return the document with every free text given, so that it still fits together."""
    made = document()
    for name, keys, kind in list(leaves(value=made)):
        if kind == Text and name not in NOT_FREE | INSTEAD:
            put(made, keys, file_name(give(name), FILES[name]) if name in FILES else give(f"{name} {keys[-1]}"))
    made["tests"][0]["groups"] = [one.strip(" \t") for one in made["tests"][0]["groups"]]  # as cells are
    made["requirements"][0]["condition"] = made["tests"][0]["condition"]
    del made["requirements"][2]["condition"]  # R1 is about the first test, R2 about none, R3 about all
    del made["conditions"], made["recordings"]["turned"]["dwells"], made["recordings"]["turned"]["tle"]
    stepped = give("RecordingEntry.conditions field").strip()
    made["recordings"]["stepped"]["conditions"] = {stepped: made["recordings"]["stepped"]["conditions"]["field"]}
    made["tests"][4]["plan"]["to"] = [stepped]
    for name in ("table", "means", "lines", "rested", "several"):
        del made["recordings"][name]["run"]  # a table has a column of runs, or of flips, instead
    for name in made["recordings"].keys() - {"laid"}:
        del made["recordings"][name]["sections"]
    for name in made["recordings"].keys() - {"shaken"}:
        del made["recordings"][name]["profile"]
    for name in made["recordings"].keys() - {"flown"}:
        made["recordings"][name].pop("curve", None)
    for name in HEADS[1:]:
        made["recordings"][name]["head"]["file"] = made["recordings"][HEADS[0]]["head"]["file"]
    turned = made["recordings"]["turned"]["positions"]
    turned[1]["flip"] = turned[0]["flip"]
    made["recordings"]["means"]["means"]["angles"] = {
        give(f"Means.angles {angle}").strip(" \t"): angle for angle in ANGLES
    }
    return made


def put(made: Any, keys: Keys, text: str) -> None:
    """Put a text into the document at a place."""
    for key in keys[:-1]:
        made = made[key]
    made[keys[-1]] = text


def file_name(text: str, ending: str) -> str:
    """Return the text as a path below the campaign: what a file system cannot hold is left out."""
    parts = text.replace("\x00", "").replace("..", "__").split("/")
    short = [part[i : i + LONGEST_NAME] for part in parts for i in range(0, len(part), LONGEST_NAME)]
    return "/".join(["data", *(part for part in short if part not in (".", ""))])[:2000] + ending


def write(folder: Path, made: dict[str, Any], runs: tuple[str, ...]) -> Path:
    """Write the campaign and the recordings that it names, ``runs`` being the labels of power-ups; return the folder.

    The tables are Parquet, which holds any text as the name of a column and as a cell.
    """
    folder.mkdir(parents=True)
    (folder / "campaign.toml").write_text(toml(made), encoding="utf-8")
    table, steps = made["recordings"]["table"], made["recordings"]["steps"]
    _save(folder / table["file"], _rows(table["rows"], made["tests"][0]["groups"], runs))
    schedule = steps["schedule"]
    starts = np.arange(len(RATES) * 2) * DWELL
    rates = np.array(RATES * 2)
    scheduled = {schedule["start"]: starts, schedule["stop"]: starts + DWELL, schedule["rate"]: rates}
    scheduled |= {schedule["recording"]: ["steps"] * len(rates)}
    _save(folder / schedule["file"], scheduled)
    time = np.arange(len(rates) * DWELL) + 0.5
    reading = 1.01 * np.repeat(rates, DWELL) + 0.02 + np.random.default_rng(2).normal(0.0, 0.002, len(time))
    _save(folder / steps["file"], {steps["clock"]["column"]: time, steps["channels"]["x"]["column"]: reading})
    _save(folder / made["recordings"]["stepped"]["file"], _stepped(made["recordings"]["stepped"]))
    _save(folder / made["recordings"]["means"]["file"], _means(made["recordings"]["means"]["means"], runs))
    _save(folder / made["recordings"]["turned"]["file"], _turned(made["recordings"]["turned"]))
    _save(folder / made["recordings"]["lines"]["file"], _lines(made["recordings"]["lines"]["lines"], runs))
    moved = made["recordings"]["moved"]
    _save(folder / moved["file"], _moved(moved))
    (folder / moved["mass"]["schedule"]).parent.mkdir(parents=True, exist_ok=True)
    write_schedule(folder / moved["mass"]["schedule"], MOVED)
    circled = made["recordings"]["circled"]
    _save(folder / circled["file"], _circled(circled))
    once = (("start [s]", 0.0), ("stop [s]", CIRCLED * 100.0), ("rate [deg/s]", 0.1), ("angle [deg]", 0.0))
    _save(
        folder / circled["turned"]["schedule"],
        {"run": [circled["turned"]["run"].strip(" \t")], **{name: np.array([value]) for name, value in once}},
    )
    _write_heads(folder, [made["recordings"][name] for name in HEADS])
    driven = made["recordings"]["driven"]
    _save(folder / driven["file"], _moved(driven))
    (folder / driven["drive"]["schedule"]).parent.mkdir(parents=True, exist_ok=True)
    write_schedule(folder / driven["drive"]["schedule"], MOVED)
    laid = made["recordings"]["laid"]
    _save(folder / laid["file"], _laid(laid))
    shaken = made["recordings"]["shaken"]
    time = np.arange(20_000) * 1e-3
    shocks = np.random.default_rng(10).standard_normal(len(time))
    _save(folder / shaken["file"], {shaken["clock"]["column"]: time, shaken["channels"]["x"]["column"]: shocks})
    (folder / shaken["profile"]).parent.mkdir(parents=True, exist_ok=True)
    (folder / shaken["profile"]).write_text("frequency [Hz],density [m2/s4/Hz]\n20,0.002\n300,0.002\n")
    flown = made["recordings"]["flown"]
    felt = 1e-4 * np.random.default_rng(11).standard_normal((3, len(time)))
    columns = {flown["channels"][axis]["column"]: felt[i] for i, axis in enumerate(AXES)}
    _save(folder / flown["file"], {flown["clock"]["column"]: time, **columns})
    (folder / flown["curve"]).parent.mkdir(parents=True, exist_ok=True)
    (folder / flown["curve"]).write_text("frequency [Hz],rms [ug]\n1,100\n300,1000\n")
    _save_flights(folder, made["recordings"]["several"], runs)
    rested = made["recordings"]["rested"]
    _save(folder / rested["file"], _rested(rested["rests"]))
    (folder / laid["sections"]).parent.mkdir(parents=True, exist_ok=True)
    (folder / laid["sections"]).write_text(json.dumps(_sections()), encoding="utf-8")
    return folder


def _save_flights(folder: Path, several: dict[str, Any], runs: tuple[str, ...]) -> None:
    _save(folder / several["file"], _several(several["flips"], runs))
    ground = folder / several["flips"]["file"]
    ground.parent.mkdir(parents=True, exist_ok=True)
    ground.write_text(dump_model(_ground()), encoding="utf-8")


def _several(flips: dict[str, Any], runs: tuple[str, ...]) -> dict[str, Any]:
    """Return a table of two flips of y and z in each of several flights."""
    n = len(runs)
    noise = np.random.default_rng(12).standard_normal(4 * n)
    return {
        flips["flight"]: [run for run in runs for _ in range(4)],
        flips["date"]: [f"{2001 + k}-01-01" for k in range(n) for _ in range(4)],
        flips["serial"]: ["head"] * (4 * n),
        flips["axis"]: ["y", "z", "y", "z"] * n,
        flips["temperature"]: np.tile([18.0, 18.0, 22.0, 22.0], n),
        flips["bias"]: np.tile([1020.0, -980.0], 2 * n) + noise,
        flips["u"]: np.ones(4 * n),
        flips["dof"]: np.full(4 * n, 20.0),
    }


def _ground() -> SensorModel:
    """Return the model of the head on the ground."""
    keys = tuple(Key("bias", axis) for axis in AXES)
    values = np.array([500.0, 1000.0, -1000.0]) * 9.80665e-6
    part = Component("ground test", "A", np.eye(3) * 1e-10)
    return model_from(Estimate(keys, values, ("m/s^2",) * 3, (part,)), "accelerometer", AXES)


def _stepped(stepped: dict[str, Any]) -> dict[str, Any]:
    (field,) = stepped["conditions"].values()
    levels = np.repeat(STEPPED, STOOD)
    reading = 0.1 + 0.02 * levels + np.random.default_rng(9).normal(0.0, 0.002, len(levels))
    return {
        stepped["clock"]["column"]: np.arange(len(levels)) + 0.5,
        stepped["channels"]["x"]["column"]: reading,
        field["column"]: levels,
    }


def _means(means: dict[str, Any], flips: tuple[str, ...]) -> dict[str, Any]:
    rng = np.random.default_rng(3)
    cells = [(axis, position, flip) for flip in flips for position in means["angles"] for axis in AXES]
    return {
        means["axis"]: [one[0] for one in cells],
        means["position"]: [one[1] for one in cells],
        means["flip"]: [one[2] for one in cells],
        means["mean"]: rng.normal(100.0, 1.0, len(cells)),
        means["predicted"]: rng.normal(100.0, 1.0, len(cells)),
        means["temperature"]: np.full(len(cells), 18.0),
        means["half_widths"]["0.95"]: np.full(len(cells), 0.2),
    }


def _turned(turned: dict[str, Any]) -> dict[str, Any]:
    rng = np.random.default_rng(4)
    time = np.arange(STOOD * len(ANGLES)) + 0.5
    codes = {one["column"]: np.rint(rng.normal(100.0, 3.0, len(time))) for one in turned["channels"].values()}
    return {turned["clock"]["column"]: time, **codes}


def _lines(lines: dict[str, Any], runs: tuple[str, ...]) -> dict[str, Any]:
    n = len(runs)
    numbers = {
        "applied": 23.0,
        "response": 0.23,
        "noise": 0.02,
        "psd_response": 0.23,
        "psd_noise": 0.02,
        "scatter": 0.1,
    }
    drawn = np.random.default_rng(5).normal(0.0, 0.01, n)
    columns: dict[str, Any] = {lines[name]: value + drawn * (name == "response") for name, value in numbers.items()}
    return columns | {lines["run"]: list(runs), lines["moved"]: ["yes"] * n}


def _moved(moved: dict[str, Any]) -> dict[str, Any]:
    pulses = 1000.0 + 1.0e8 * MOVED.applied + np.random.default_rng(6).normal(0.0, 3.0, len(MOVED))
    return {moved["clock"]["column"]: MOVED.middle + 0.5, moved["channels"]["x"]["column"]: np.rint(pulses)}


def _circled(circled: dict[str, Any]) -> dict[str, Any]:
    time = np.arange(CIRCLED) * 100.0 + 50.5
    rate = 177.0 - 1.7e-3 * np.cos(np.radians(0.1 * time)) + np.random.default_rng(11).normal(0.0, 3e-3, CIRCLED)
    pulses = np.diff(np.floor(np.cumsum(np.append(0.0, 100.0 * rate))))
    return {circled["clock"]["column"]: time, circled["channels"]["x"]["column"]: pulses}


def _write_heads(folder: Path, heads: list[dict[str, Any]]) -> None:
    """Write what three heads on a line read, and the file of their body."""
    rng = np.random.default_rng(9)
    time, felt = np.arange(400.0) + 0.5, rng.normal(0.0, 1e-3, (400, 3))
    body: dict[str, Any] = {}
    for number, one in enumerate(heads):
        read = felt + rng.normal(0.0, 1e-5, (400, 3))
        columns = {one["channels"][axis]["column"]: read[:, i] for i, axis in enumerate(AXES)}
        _save(folder / one["file"], {one["clock"]["column"]: time, **columns})
        place = ["0 m", f"{number} m", "0 m"]
        body[one["head"]["name"]] = {"position": place, "position_u": "1 mm"} | ({"calibrated": True} if number else {})
    path = folder / heads[0]["head"]["file"]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(toml({"heads": body}), encoding="utf-8")


def _laid(laid: dict[str, Any]) -> dict[str, Any]:
    rng = np.random.default_rng(7)
    up = np.repeat(
        np.vstack([np.eye(3)[AXES.index(face[0])] * float(f"{face[1]}1") for face in FACES * 2]), LAID, axis=0
    )
    place = np.repeat(rng.normal(0.0, 1e-3, (len(FACES) * 2, 3)), LAID, axis=0)
    readings = 9.79 * up + place + rng.normal(0.0, 5e-3, up.shape)
    columns = {laid["channels"][axis]["column"]: readings[:, i] for i, axis in enumerate(AXES)}
    return {laid["clock"]["column"]: np.arange(len(up)) / 50.0, **columns}


def _rested(rests: dict[str, Any]) -> dict[str, Any]:
    rng = np.random.default_rng(8)
    up = np.vstack([np.eye(3)[AXES.index(face[0])] * float(f"{face[1]}1") for face in FACES * 2])
    readings = 9.79 * up + rng.normal(0.0, 1e-3, up.shape)
    columns = {rests["orientation"]: list(FACES * 2), rests["samples"]: np.full(len(up), LAID)}
    for i, axis in enumerate(AXES):
        columns |= {rests["reading"][axis]: readings[:, i], rests["scatter"][axis]: np.full(len(up), 5e-3),
                    rests["direction"][axis]: up[:, i]}  # fmt: skip
    return columns


def _sections() -> dict[str, Any]:
    """Return where each position lies, each face twice: a blank makes another key."""
    labels = [*FACES, *(f" {face}" for face in FACES)]
    return {label: {"start": i * LAID, "end": (i + 1) * LAID} for i, label in enumerate(labels)}


def _rows(rows: dict[str, str], groups: list[str], runs: tuple[str, ...]) -> dict[str, Any]:
    rng = np.random.default_rng(1)
    cells = [(rate, group, run) for run in runs for group in groups for rate in RATES]
    rate = np.array([one[0] for one in cells])
    offset = np.repeat(rng.normal(0.0, 0.002, len(runs)), len(groups) * len(RATES))
    return {
        rows["applied"]: rate,
        rows["reading"]: 1.01 * rate + 0.01 + offset + rng.normal(0.0, 0.001, len(rate)),
        rows["scatter"]: np.full(len(rate), 0.004),
        rows["samples"]: np.full(len(rate), 20),
        rows["axis"]: ["x"] * len(rate),
        rows["group"]: [one[1] for one in cells],
        rows["run"]: [one[2] for one in cells],
        rows["time"]: 1.0e9 + DWELL * np.arange(len(rate)),
    }


def _save(path: Path, columns: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.table({name: pa.array(values) for name, values in columns.items()}), path)


def toml(value: Any, top: bool = True) -> str:
    """Return the value as TOML: a line a table at the top, everything below inline."""
    if isinstance(value, dict):
        pairs = [f"{toml(key, False)} = {toml(one, False)}" for key, one in value.items()]
        return "\n".join([*pairs, ""]) if top else f"{{ {', '.join(pairs)} }}"
    if isinstance(value, list):
        return f"[{', '.join(toml(one, False) for one in value)}]"
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
