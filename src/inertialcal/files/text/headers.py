"""Headers: what the name of a column says about axis, quantity and unit.

A unit stands in brackets (``gyro_x [deg/s]``, ``Time (s)``) or as the end of the name (``gyro_x_dps``,
``acc_mps2``, ``temp_degC``, ``slope_volt_per_dps``), from a closed list. A unit that cannot belong to the
quantity (``gyro_g``) is none. What a name does not say stays unsaid.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from unicodedata import combining

from ...core import units
from ...core.errors import InertialcalError

# English, German, French, Italian, Spanish; letters without their marks (`plain`).
GYRO = {"gyro", "gyros", "gyr", "gyroscope", "gyroscopes", "omega", "angvel"}
GYRO |= {"drehrate", "drehraten", "winkelgeschwindigkeit", "kreisel", "gyrometre", "gyrometres"}
GYRO |= {"giroscopio", "giroscopi", "giroscopios", "giro"}
# About which axis of a vehicle a rate is: forwards, sideways, up or down.
ABOUT = {
    "x": {"roll", "wank", "roulis", "rollio", "alabeo"},
    "y": {"pitch", "nick", "tangage", "beccheggio", "cabeceo"},
    "z": {"yaw", "gier", "lacet", "imbardata", "guinada"},
}
RATE = {"vitesse", "rate", "rotation"}  # of what turns, where it is read in volts or counts about an axis
RAW = {"voltage", "count"}
ACC = {"acc", "accs", "accel", "accels", "accl", "accelerometer", "accelerometers", "acceleration", "accelerations"}
ACC |= {"beschleunigung", "beschleunigungen", "beschl", "accelerometre", "accelerometres"}
ACC |= {
    "accelerometro",
    "accelerometri",
    "accelerazione",
    "accelerazioni",
    "acelerometro",
    "aceleracion",
    "aceleraciones",
}
MAGNETOMETER = {"mag", "magn", "magnetometer", "magnetic"}
MAGNETOMETER |= {"magnetfeld", "flussdichte", "magnetometre", "magnetique"}
TEMPERATURE = {"temp", "temps", "temperature", "temperatures", "tmp", "thermistor", "temperatur", "temperaturen"}
TEMPERATURE |= {"temperatura", "temperaturas"}
PRESSURE = {"pressure", "press", "baro", "barometer", "druck", "luftdruck", "pression"}
PRESSURE |= {"pressione", "presion"}
VOLTAGE = {"voltage", "volt", "volts", "vref", "spannung", "tension", "tensione", "voltaje"}
TIME = {"time", "timestamp", "timestamps", "stamp", "unix", "epoch", "utc", "datetime", "walltime", "date"}
TIME |= {"zeit", "zeitstempel", "datum", "uhrzeit", "messzeit", "heure", "horodatage", "gmt"}
TIME |= {"tempo", "ora", "fecha", "hora", "tiempo", "marcatemporale"}
NOT_TIME = {"sigma", "std", "deviation", "error", "constant", "interval", "step", "delta", "diff", "duration"}
OFFSET = {"relative"}  # of a stamp to another one, where a sensor is named beside it
NOT_TIME |= {"konstante", "abstand", "dauer", "constante", "intervalle", "duree"}
SPREAD = {"std", "stdev", "stddev", "sd", "sigma", "standardabweichung", "stabw", "streuung", "ecarttype"}
# What a table says was applied, beside what was read.
APPLIED = {"applied", "app", "reference", "ref", "true", "truth", "nominal", "nom", "commanded", "command", "cmd"}
APPLIED |= {"expected", "ideal", "theoretical", "soll", "sollwert", "up"}
# Of a controller: what it was asked for, which is no reading.
SET = {
    "setpoint",
    "soll",
    "sollwert",
    "solltemperatur",
    "consigne",
    "consigna",
    "target",
    "commanded",
    "command",
    "cmd",
}
STATUS = {"status", "state", "flag", "flags", "valid", "validity", "mode", "quality"}
WORDS = (
    ("gyro", GYRO),
    ("acc", ACC),
    ("magnetometer", MAGNETOMETER),
    ("temperature", TEMPERATURE),
    ("pressure", PRESSURE),
    ("voltage", VOLTAGE),
    ("time", TIME),
    ("status", STATUS),
)
PHRASES = {
    "angular velocity": "gyro", "angular rate": "gyro", "rotation rate": "gyro", "vitesse angulaire": "gyro",
    **{f"{word} rate": "gyro" for known in ABOUT.values() for word in known},
    "velocita angolare": "gyro", "velocidad angular": "gyro", "velocita di rotazione": "gyro",
    "vitesse de rotation": "gyro", "ecart type": "spread",
    "deviazione standard": "spread", "desviacion estandar": "spread", "desviacion tipica": "spread",
}  # fmt: skip
LETTERS = {"w": "gyro", "g": "gyro", "a": "acc", "m": "magnetometer"}  # wx, gx, ax, mx
THREES = (
    "xyz",
    "pqr",
)  # letters by which three columns of one sensor differ: ``rx``, ``ry``, ``rz``; ``p``, ``q``, ``r``

# Whole names (letters and digits only, lower case).
TIME_NAMES = {
    "t": None,
    "ts": None,
    "temps": None,
    "sekunden": "s",
    "secondes": "s",
    "millisekunden": "ms",
    "elapsed": None,
    "seconds": "s",
    "secs": "s",
    "sec": "s",
    "millis": "ms",
    "milliseconds": "ms",
    "msec": "ms",
    "micros": "us",
    "microseconds": "us",
    "usec": "us",
    "nanos": "ns",
    "nanoseconds": "ns",
    "nsec": "ns",
    "secondselapsed": "s",
    "elapsedseconds": "s",
    "elapseds": "s",
    "elapsedms": "ms",
    "millisecondselapsed": "ms",
}
_INDEX_NAMES = (
    "nsamples nsample samples sample samplenumber sampleno samplenr sampleindex sampleid sampleidx index idx "
    "row rows rownumber rowno line frame frames frameno framenumber framecount counter packetcounter packet "
    "seq sequence sequencenumber i n nr no number anzahl nombre tick ticks record recordno unnamed0 indexlevel0 "
    "readingnumber readingno scan scannumber datacntr"
)
INDEX_NAMES = frozenset(_INDEX_NAMES.split())

SUFFIXES = {
    "dps": "deg/s",
    "degps": "deg/s",
    "radps": "rad/s",
    "rads": "rad/s",
    "mdps": "mdeg/s",
    "dph": "deg/h",
    "mps2": "m/s^2",
    "g": "g",
    "mg": "mg",
    "ug": "ug",
    "ng": "ng",
    "degc": "degC",
    "degf": "degF",
    "kelvin": "K",
    "volt": "V",
    "volts": "V",
    "mv": "mV",
    "uv": "uV",
    "lsb": "count",
    "count": "count",
    "counts": "count",
    "percent": "%",
    "pct": "%",
    "ppm": "ppm",
    "pps": "count/s",
    "hz": "Hz",
    "torr": "Torr",
    "pa": "Pa",
    "hpa": "hPa",
    "kpa": "kPa",
    "mbar": "mbar",
    "s": "s",
    "sec": "s",
    "ms": "ms",
    "us": "us",
    "ns": "ns",
    "deg": "deg",
    "rad": "rad",
    "mrad": "mrad",
    "urad": "urad",
    "cm": "cm",
    "mm": "mm",
    "kg": "kg",
}
PAIRS = {("deg", "s"): "deg/s", ("rad", "s"): "rad/s", ("deg", "h"): "deg/h", ("m", "s2"): "m/s^2"}
PAIRS |= {("deg", "sec"): "deg/s", ("rad", "sec"): "rad/s", ("deg", "hr"): "deg/h"}

# Kinds of unit that a quantity can come in, raw ones included; others may come in any.
KINDS = {
    "gyro": {"angular_rate", "angle", "voltage", "count", "frequency", "other"},
    "acc": {"acceleration", "velocity", "voltage", "count", "frequency", "other"},
    "temperature": {"temperature", "voltage", "count", "other"},
    "time": {"time"},
    "pressure": {"pressure", "voltage", "count"},
    "voltage": {"voltage", "count"},
}
BY_KIND = {
    "angular_rate": "gyro",
    "acceleration": "acc",
    "temperature": "temperature",
    "time": "time",
    "pressure": "pressure",
    "voltage": "voltage",
}
SENSOR_WORDS = {"gyro": GYRO, "acc": ACC}
# Readings that core.units refuses on its own, and that the quantity settles.
SETTLED = {("temperature", "C"): "degC", ("temperature", "F"): "degF", ("acc", "G"): "g", ("acc", "mG"): "mg"}
SETTLED |= {("acc", "ms2"): "m/s^2"}
WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+")
COUNTED = re.compile(r"(.*\S)\[([012])\]")
OF_SENSOR = re.compile(r"\bLBL: ([^,)]+)")  # of a HOBO, what its owner calls a sensor
OF_GRAPH = re.compile(r"[XY]\[[0-9]+\]", re.IGNORECASE)  # as LabVIEW counts the curves of a graph: no axes
AFTER = re.compile(
    r"(?:, *| in | / )([^\s,]+)$"
)  # a unit behind the name: ``Temp, °C``, ``Drehrate in °/s``, ``t / s``
UNNAMED = re.compile(r"(?:.*_)?[0-9]+")  # ``column_3``, ``imu_2``: columns of a file, or matrix, without names
CLOSING = {"]": "[", ")": "("}


@dataclass(frozen=True)
class Heading:
    """What a name says."""

    unit: str | None = None  # As ``core.units`` prints it; None where the name says none
    axis: str = ""  # ``"x"``, ``"y"``, ``"z"`` or ``""``
    # ``"gyro"``, ``"acc"``, ``"magnetometer"``, ``"temperature"``, ``"pressure"``, ``"voltage"``, ``"time"``,
    # ``"status"``, ``"index"``, ``"spread"`` (a standard deviation beside its mean) or ``""``
    quantity: str = ""
    unknown: str = ""  # Text in brackets that is no unit


@lru_cache(1024)  # files of one logger have the same names
def heading(name: str, unit: str | None = None) -> Heading:
    """Return what the name of a column says.

    Parameters
    ----------
    name : str
        As the file has it.
    unit : str, optional
        As a units row or metadata say it; goes before the name.
    """
    named, given = _behind(bare_name(name), in_brackets(name)) if unit is None else (bare_name(name), unit)
    bare = plain(named)
    words = [word.lower() for word in WORD.findall(bare)]
    known, rest = _suffix(bare)
    known = known if given is None else None
    quantity = _quantity(bare, [word.lower() for word in WORD.findall(rest)] if known else words)
    if given is not None and given.strip():
        known = _known(given.strip(), quantity)
    known = TIME_NAMES.get("".join(_last(bare, words))) if known is None and given is None else known
    known = SETTLED.get((quantity, re.split(r"[_\s.]+", bare)[-1])) if known is None and given is None else known
    kind = units.kind(known) if known is not None else ""
    if quantity == "time" and kind == "temperature" and bare.lower() == "temps":  # times in French
        quantity = "temperature"
    if quantity == "spread":
        return Heading(known, "", quantity, "")
    if not quantity and kind in RAW and RATE.intersection(words) and _axis(words):
        quantity = "gyro"  # ``Vitesse X (V)``: in m/s it is none
    unknown = (
        given.strip() if given is not None and known is None and ":" not in given and _opening(name) != 0 else ""
    )  # ``LGR S/N: 123``
    if (bare, kind) == ("T", "temperature"):
        quantity = kind
    if quantity == "index" and kind in BY_KIND and kind != "time":  # ``i [g]``
        quantity = ""
    other = BY_KIND.get(kind, "")
    if {quantity, other} <= SENSOR_WORDS.keys() and (
        SENSOR_WORDS[other].intersection(words) or not _quantity(bare, words, letters=False)
    ):
        quantity = other  # ``acc_GYRO_3_x [m/s^2]``, of a box called GYRO; ``gx [g]``: a letter says less than a unit
    if known is not None and quantity in KINDS and kind not in KINDS[quantity]:
        known, unknown = None, given or ""
    axis = "" if OF_GRAPH.fullmatch(name.strip()) else _axis(words)
    axis = axis or (about_axis(bare) if kind == "angular_rate" or quantity == "gyro" else "")
    if not quantity and not (axis and kind in RAW):  # ``x [V]`` is an axis of a sensor, like ``x [count]``
        quantity = BY_KIND.get(kind, "")
    quantity, axis = (quantity, axis) if axis or kind not in RAW else _labelled(name, quantity)
    return Heading(known, axis, quantity, unknown)


def _labelled(name: str, quantity: str) -> tuple[str, str]:
    """Return quantity and axis of a column in volts by its label: ``Volt, V (SEN S/N: 123, LBL: Gyro Z)``."""
    label = OF_SENSOR.search(name)
    said = heading(label[1]) if label else None
    return (quantity, "") if said is None or said.quantity not in SENSOR_WORDS else (said.quantity, said.axis)


def heading_within(name: str, unit: str | None, group: str) -> Heading:
    """Return what the name of a column says; of an axis alone, of which sensor it is, by the group it is in."""
    said = heading(name, unit)
    if not said.axis or said.quantity or not group:
        return said
    within = heading(f"{group} {name}", unit)
    return Heading(within.unit, said.axis, within.quantity, within.unknown) if within.quantity in SENSOR_WORDS else said


def plain(name: str) -> str:
    """Return a name without the marks of its letters: ``Température`` as ``Temperature``."""
    return name if name.isascii() else "".join(c for c in unicodedata.normalize("NFD", name) if not combining(c))


def about_axis(name: str) -> str:
    """Return the axis of a vehicle that a name says, of a rate: ``roll_rate``, ``Gierrate``; else ``""``."""
    words = {word.lower().removesuffix("rate") for word in WORD.findall(plain(bare_name(name)))}
    found = [axis for axis, known in ABOUT.items() if known & words]
    return found[0] if len(found) == 1 else ""


def sensor_of_stamps(name: str) -> str:
    """Return the sensor, ``"gyro"`` or ``"acc"``, whose stamps a column holds by its name (``acc_time``), or ``""``."""
    words = [word.lower() for word in WORD.findall(bare_name(name))]
    if not TIME.intersection(words) or (NOT_TIME | OFFSET).intersection(words) or _axis(words):
        return ""
    return next((one for one, known in (("gyro", GYRO), ("acc", ACC)) if known.intersection(words)), "")


def is_applied(name: str) -> bool:
    """Whether a column is called an input that was applied: ``gx_applied [g]``."""
    return not APPLIED.isdisjoint(word.lower() for word in WORD.findall(bare_name(name)))


def is_set_point(name: str) -> bool:
    """Whether a column is called what a controller was asked for: ``setpoint_degC``, ``Set Temp (C)``."""
    words = [word.lower() for word in WORD.findall(plain(bare_name(name)))]
    return not SET.isdisjoint(words) or words[:1] == ["set"] or ("set", "point") in pairwise(words)


def bare_name(name: str) -> str:
    """Return the name without a unit in brackets."""
    at = _opening(name)
    return name.strip()[:at].strip(" _,/") if at else name.strip()


def full_name(names: Sequence[str], name: str) -> str | None:
    """Return the column of a name given with or without the unit in brackets; None where there is not one.

    Columns that have no names are found by their number, too: ``2`` is ``column_2``, or ``imu_2`` of a matrix ``imu``
    whose columns alone the names are.
    """
    exact = [known for known in names if known == name]
    found = exact or [known for known in names if bare_name(known) == name]
    if not found and name.isascii() and name.isdigit():
        stems = {stem for known in names for stem, line, number in [known.rpartition("_")] if line and number.isdigit()}
        found = [known for known in names if {known.rpartition("_")[0]} == stems and known.endswith(f"_{name}")]
    return found[0] if len(found) == 1 else None


def normal_unit(text: str, quantity: str) -> str:
    """Return a unit as ``core.units`` prints it; the quantity settles what C, F and G mean.

    Raises
    ------
    DataError
        If it is not known.
    """
    return units.normalise(SETTLED.get((quantity, text), text))


def _opening(name: str) -> int | None:
    """Index of the bracket that opens the end of a name."""
    name = name.strip()
    closing = name[-1:]
    if closing not in CLOSING:
        return None
    depth = 0
    for at in range(len(name) - 1, -1, -1):
        depth += (name[at] == closing) - (name[at] == CLOSING[closing])
        if depth == 0:
            return at
    return None


def in_brackets(name: str) -> str | None:
    """Return what stands in brackets at the end of a name; a number there counts columns, and is no unit."""
    at = _opening(name)
    inside = None if at is None else name.strip()[at + 1 : -1]
    return None if inside is None or inside.strip().isdecimal() else inside


def counted_axis(name: str) -> tuple[str, str]:
    """Return name and axis of a column of three that are counted as a program counts: ``gyroADC[0]``; else ``""``."""
    found = COUNTED.fullmatch(name.strip())
    return (found[1], "xyz"[int(found[2])]) if found else ("", "")


def _known(text: str, quantity: str) -> str | None:
    try:
        return normal_unit(text, quantity)
    except InertialcalError:
        return None


def _behind(named: str, bracket: str | None) -> tuple[str, str | None]:
    """Return a name without the unit behind it, and that unit; else both as they are.

    A unit in brackets goes before it; a letter alone is an axis, or a part of a name, as well, but s, g and V.
    """
    said = AFTER.search(named)
    if said is None or (bracket is not None and _known(bracket, "") is not None):
        return named, bracket
    is_unit = said[1] in ("s", "g", "V") or (len(said[1]) > 1 and _known(said[1], "temperature") is not None)
    return (named[: said.start()], said[1]) if is_unit else (named, bracket)


def _last(bare: str, words: list[str]) -> list[str]:
    """Words of the last part of a path: ``imu.t``."""
    return [word.lower() for word in WORD.findall(bare.rpartition(".")[2])] if "." in bare else words


def _suffix(bare: str) -> tuple[str | None, str]:
    """Return the unit at the end of a name, and the name without it."""
    parts = re.split(r"[_\s.]+", bare)
    for count in range(min(len(parts) - 1, 5), 0, -1):
        unit = _words_to_unit([part.lower() for part in parts[-count:]])
        if unit is not None:
            return _known(unit, ""), " ".join(parts[:-count])
    return ("V", " ".join(parts[:-1])) if len(parts) > 1 and parts[-1] == "V" else (None, bare)


def _words_to_unit(parts: list[str]) -> str | None:
    """``["volt", "per", "dps"]`` as ``V/(deg/s)``."""
    if "per" in parts:
        at = parts.index("per")
        above, below = _words_to_unit(parts[:at]), _words_to_unit(parts[at + 1 :])
        return None if above is None or below is None else f"{above}/({below})"
    if len(parts) == 1:
        return SUFFIXES.get(parts[0])
    return PAIRS.get((parts[0], parts[1])) if len(parts) == 2 else None


def _quantity(bare: str, words: list[str], letters: bool = True) -> str:
    """Return what a column measures, by its name; by one of the ``LETTERS`` too, where they count."""
    whole = "".join(_last(bare, words))
    if len(words) > 1 and SPREAD.intersection(words) and not TIME.intersection(words):
        return "spread"
    if whole in INDEX_NAMES or bare == "#":
        return "index"
    if whole in TIME_NAMES or sensor_of_stamps(bare):
        return "time"
    spaced = " ".join(words)
    for phrase, quantity in PHRASES.items():
        if phrase in spaced:
            return quantity
    if len(words) == 2 and words[0] == "ac" and words[1] in ("x", "y", "z"):  # ``AcX``, beside ``GyX``
        words = ["acc", words[1]]
    of_sensor = words[-1:] and (words[-1] in TEMPERATURE or not _axis(words))  # ``gyro_temp``
    if "free" in words:  # of gravity: no reading of a sensor
        words = [word for word in words if word not in ACC]
    for quantity, known in (("temperature", TEMPERATURE if of_sensor else set()), *WORDS):
        if any(_stem(word) in known or word in known for word in words):
            return "" if quantity == "time" and NOT_TIME.intersection(words) else quantity
    pairs = [word for word in words if letters and len(word) == 2 and word[0] in LETTERS and word[1] in "xyz"]
    return LETTERS[pairs[0][0]] if pairs else ""


def _stem(word: str) -> str:
    """``accelx``, ``xgyro`` without the letter of the axis."""
    if len(word) > 3 and word[-1] in "xyz":
        return word[:-1]
    return word[1:] if len(word) > 3 and word[0] in "xyz" else word


def _axis(words: list[str]) -> str:
    """Axis, where the name has one letter x, y or z, or one word that starts or ends with it."""
    found = {word for word in words if word in ("x", "y", "z")}
    if not found:
        found = {word[1] for word in words if len(word) == 2 and word[0] in LETTERS and word[1] in "xyz"}
    if not found:
        found = {
            word[-1] if word.startswith(_stem(word)) else word[0]
            for word in words
            if _stem(word) != word and any(_stem(word) in known for _, known in WORDS)
        }
    return found.pop() if len(found) == 1 else ""
