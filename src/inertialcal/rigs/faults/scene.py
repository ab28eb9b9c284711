"""Scene: a simulated campaign on its way to be spoiled, recording by recording, as its campaign file names them.

What a column means is read from the campaign file: which are the axes of a sensor, where zero is, how many stored units
one unit of the input is. So a fault fits every rig, in counts or in m/s².
"""

from __future__ import annotations

import re
import tomllib
import zlib
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Channel
from ...core.units import factor, parse_quantity, si_unit
from ..twin import Extra, Fault, Twin

Rows = slice | NDArray[Any]
Act = Callable[[Array], Array]
NORMAL = 0.6745 * np.sqrt(6.0)  # median of a second difference of white noise, over its standard deviation
GRIDS = (1.0, 1.0 / 200.0)  # steps of counts that are stored [counts]
SETTLED = 0.1  # part at either end of a recording where no sample is spoiled


def spoiled(twin: Twin, fault: Fault, size: float) -> Twin:
    """Return a twin with a general fault in it; where it lies follows from the seed and the name of the fault."""
    scene = Scene(twin, fault.procedures)
    if fault.spoil is not None:
        fault.spoil(scene, size)
    every = {name for place in scene.places for name in place.names}
    if every <= set(scene.spoiled):
        scene.spoiled.clear()  # one as well as the other
    return replace(
        twin, campaign=scene.campaign, recordings=scene.recordings, extras=scene.extras, texts=scene.texts,
        truth=scene.truth,
        spoiled=tuple(dict.fromkeys(scene.spoiled)),
    )  # fmt: skip


@dataclass(frozen=True)
class Signal:
    """The column of an axis: how it is stored."""

    file: str
    column: str
    axis: str
    kind: str  # Of the sensor: ``"gyro"``, ``"accelerometer"``
    zero: str  # Column of its reference voltage; empty where zero is 0
    per_si: float  # Stored units an SI unit of the input
    ends: tuple[float, float] | None  # Of the converter [stored units]


@dataclass(frozen=True)
class Place:
    """A file of recordings that a fault may spoil: what the campaign says of it."""

    file: str
    names: tuple[str, ...]  # Recordings that it holds
    entry: Mapping[str, Any]  # Of the first of them
    signals: tuple[Signal, ...]  # Axis channels of all of them
    test: str
    use: str
    procedure: str

    @property
    def run(self) -> str:
        """Power-up; the file where none is said."""
        return str(self.entry.get("run", self.file))

    @property
    def like(self) -> tuple[object, ...]:
        """What it has in common with others of its kind: procedure, axis that is turned, whether a mass is moved."""
        return self.procedure, self.entry.get("axis"), self.entry.get("mass", {}).get("moved", True)


class Scene:
    """Recordings, other files and campaign text of a twin, to be changed in place.

    Parameters
    ----------
    twin : Twin
        As it was made.
    tests : collection of str
        Procedures whose recordings the fault can spoil.
    """

    def __init__(self, twin: Twin, tests: Collection[str]):
        self.campaign, self.tests, self.truth = twin.campaign, tests, twin.truth
        self.recordings = dict(twin.recordings)
        self.extras: dict[str, Extra] = dict(twin.extras)
        self.texts = dict(twin.texts)
        self.spoiled: list[str] = []
        self.rng = np.random.default_rng([twin.seed, zlib.crc32(twin.fault.encode())])

    @cached_property
    def document(self) -> dict[str, Any]:
        """Content of the campaign file, as it was."""
        return tomllib.loads(self.campaign)

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """Files of the tests of the fault, in the order of the campaign; of several tests the first counts."""
        found: dict[str, Place] = {}
        for test in self.document["tests"]:
            names: dict[str, list[str]] = {}
            for name in test["recordings"] if test["procedure"] in self.tests else ():
                names.setdefault(self.document["recordings"][name]["file"], []).append(name)
            for file, own in names.items():
                entry = self.document["recordings"][own[0]]
                signals = tuple(signal for name in own for signal in self._signals(name))
                place = Place(file, tuple(own), entry, signals, test["id"], test.get("use", "fit"), test["procedure"])
                found.setdefault(file, place)
        return tuple(found.values())

    def fitted(self) -> tuple[Place, ...]:
        """Return those of tests that are fitted."""
        return tuple(place for place in self.places if place.use == "fit")

    def chosen(self) -> Place:
        """Return a file of a test that is fitted, by chance, and note it as spoiled; a mass at rest is not chosen."""
        moved = [place for place in self.fitted() if place.entry.get("mass", {}).get("moved", True)]
        place = moved[int(self.rng.integers(len(moved)))]
        self.note(place)
        return place

    def chosen_run(self) -> tuple[Place, ...]:
        """Return the files of one power-up that is fitted, by chance, and note them as spoiled."""
        first = self.chosen()
        self.spoiled.clear()
        run = tuple(one for one in self.fitted() if (one.run, one.procedure) == (first.run, first.procedure))
        for place in run:
            self.note(place)
        return run

    def note(self, place: Place) -> None:
        """Note the recordings of a file as spoiled."""
        self.spoiled.extend(place.names)

    def signal(self, place: Place, own: bool = False) -> Signal:
        """Return one axis of a file, by chance; ``own``: that which is turned, where one is."""
        turned = [one for one in place.signals if own and one.axis == place.entry.get("axis")]
        signals = turned or list(place.signals)
        return signals[int(self.rng.integers(len(signals)))]

    def used(self, place: Place) -> tuple[slice, ...]:
        """Return the samples of a file that its test takes: windows of positions, or all but the ends."""
        recording = self.recordings[place.file]
        windows = place.entry.get("positions")
        if not windows or recording.time_ns is None:
            n = len(recording)
            return (slice(round(SETTLED * n), n - round(SETTLED * n)),)
        seconds = [[datetime.fromisoformat(one[end]).timestamp() for end in ("start", "stop")] for one in windows]
        ends = [np.searchsorted(recording.time_ns, np.array(pair) * SECOND) for pair in seconds]
        trims = [(int(a), int(b), (int(b) - int(a)) // 6) for a, b in ends]
        return tuple(slice(a + trim, b - trim) for a, b, trim in trims)

    def somewhere(self, place: Place, length: int = 1) -> int:
        """Return the first of so many samples in a row that the test takes, by chance."""
        parts = self.used(place)
        part = parts[int(self.rng.integers(len(parts)))]
        return int(self.rng.integers(part.start, max(part.stop - length, part.start + 1)))

    def middle(self, place: Place) -> int:
        """Return a sample between 40 and 60 % of those that the test takes, by chance."""
        taken = np.concatenate([np.arange(part.start, part.stop) for part in self.used(place)])
        return int(taken[round(self.rng.uniform(0.4, 0.6) * len(taken))])

    # ---- columns ----------------------------------------------------------------------------------------------

    def values(self, file: str, column: str) -> Array:
        """Return a column as floats, shape (n,)."""
        return np.array(self.recordings[file].channel(column).data, dtype=np.float64)

    def put(self, file: str, column: str, values: Array, ends: tuple[float, float] | None = None) -> None:
        """Replace a column: rounded to the codes that the old one had, and cut at the ends of the converter."""
        recording = self.recordings[file]
        old = recording.channel(column)
        new = values if ends is None else np.clip(values, *ends)
        if old.data.dtype.kind in "iu":
            limits = np.iinfo(old.data.dtype)
            new = np.clip(np.rint(new), limits.min, limits.max)
        elif ends is not None and (grid := _grid(old.data)):
            new = np.rint(new / grid) * grid
        channel = replace(old, data=new.astype(old.data.dtype))
        self._set(file, [channel if one.name == column else one for one in recording.channels])

    def change(self, signal: Signal, act: Act, rows: Rows = slice(None)) -> None:
        """Change readings of an axis: ``act`` gets them above zero [stored units]."""
        values = self.values(signal.file, signal.column)
        zero = self.values(signal.file, signal.zero) if signal.zero else np.zeros(len(values))
        values[rows] = zero[rows] + act(values[rows] - zero[rows])
        self.put(signal.file, signal.column, values, signal.ends)

    def shift(self, signal: Signal, amount: Array | float, rows: Rows = slice(None)) -> None:
        """Add to readings of an axis [stored units]."""
        self.change(signal, lambda values: values + amount, rows)

    def scale(self, signal: Signal, by: float, rows: Rows = slice(None)) -> None:
        """Multiply readings of an axis."""
        self.change(signal, lambda values: by * values, rows)

    def sigma(self, signal: Signal) -> float:
        """Return the standard deviation of a sample [stored units], from second differences."""
        second = np.abs(np.diff(self.values(signal.file, signal.column), 2))
        sigma = float(np.median(second)) / NORMAL
        return sigma or float(np.sqrt(np.mean(second**2) / 6.0)) or 1.0

    def seconds(self, file: str) -> Array:
        """Return the time of the samples since the first of them [s], shape (n,)."""
        found = self.recordings[file].seconds
        assert found is not None  # noqa: S101 - recordings of rigs have a clock
        return found

    def take(self, file: str, rows: Rows, time_ns: NDArray[np.int64] | None = None) -> None:
        """Keep some rows of a file, in the order given, with their own stamps or with others."""
        recording = self.recordings[file]
        channels = tuple(replace(one, data=one.data[rows]) for one in recording.channels)
        assert recording.time_ns is not None  # noqa: S101 - recordings of rigs have a clock
        stamps = recording.time_ns[rows] if time_ns is None else time_ns
        self.recordings[file] = replace(recording, channels=channels, time_ns=stamps)

    def stamp(self, file: str, time_ns: NDArray[np.int64]) -> None:
        """Give a file other stamps."""
        self.recordings[file] = replace(self.recordings[file], time_ns=time_ns)

    def columns(self, place: Place, role: str) -> Iterator[str]:
        """Yield the columns of a role, or of that role by axis: ``temperature``, ``temperature_x``."""
        for name in place.names:
            for channel, one in self.document["recordings"][name]["channels"].items():
                if channel == role or channel in {f"{role}_{axis}" for axis in AXES}:
                    yield one["column"]

    def edit(self, pattern: str, new: str | Callable[[re.Match[str]], str], count: int = 1) -> None:
        """Change the text of the campaign file."""
        self.campaign, found = re.subn(pattern, new, self.campaign, count=count, flags=re.MULTILINE)
        if not found:
            raise ValueError(f"the campaign has no {pattern}")

    def _set(self, file: str, channels: list[Channel]) -> None:
        self.recordings[file] = replace(self.recordings[file], channels=tuple(channels))

    def _signals(self, name: str) -> Iterator[Signal]:
        entry = self.document["recordings"][name]
        sensor = self.document["sensors"][entry["sensor"]]
        chain, channels = sensor.get("chain", {"kind": "none"}), entry["channels"]
        for axis in sensor["axes"]:
            if axis in channels:
                one = channels[axis]
                zero = channels.get(f"reference_{axis}", {}).get("column", "")
                counts = one["unit"] == "count" and chain["kind"] == "adc"
                ends = (float(chain["counts"][0]), float(chain["counts"][1])) if counts else None
                per_si = _stored_per_si(chain, one["unit"], axis)
                yield Signal(entry["file"], one["column"], axis, sensor["kind"], zero, per_si, ends)


def _grid(data: NDArray[Any]) -> float:
    """Return the step of stored counts; 0 where they have none."""
    head = np.asarray(data[:1000], dtype=np.float64)
    return next((grid for grid in GRIDS if np.allclose(head / grid, np.rint(head / grid), atol=1e-6)), 0.0)


def _stored_per_si(chain: Mapping[str, Any], unit: str, axis: str) -> float:
    """Return how many stored units one SI unit of the input is."""

    def own(key: str) -> Any:
        value = chain.get(key, 1)
        return value[axis] if isinstance(value, Mapping) else value

    if unit != "count":
        return 1.0 / factor(unit, si_unit(unit))
    scale = parse_quantity(str(own("scale_factor")))
    if chain["kind"] == "pulse_rate":
        return scale.to("count/s/(m/s^2)") * parse_quantity(str(chain["gate"])).to("s")
    si = "V/(rad/s)" if "deg" in scale.unit or "rad" in scale.unit else "V/(m/s^2)"
    return scale.to(si) * float(own("gain")) / parse_quantity(str(chain["lsb"])).to("V")
