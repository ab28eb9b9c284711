"""What looks like a run, or a profile: the command to type next, a draft of the tests; what holds vibration at all."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...core.key import AXES
from ...core.recording import Channel, Recording
from ...core.units import factor, kind, same_dimension
from ...files.info.motion import accelerometers, gyros
from ...files.info.survey import Survey
from ...files.text.headers import bare_name
from ...files.text.table import Table
from ...signals.vibration.recognised import LONGEST, Kind, recognised
from ..sine_survey.given import controls as named_controls
from ..suggestions import Claim, Draft, FolderFile, Strength, Suggestion, fill_in, recording_table, sensor_table
from .plan import CONTROLS

FREQUENCY, DENSITY = ("frequency", "freq", "f"), ("density", "asd", "psd", "level")
NODES = 1000  # of a profile: a longer table is a spectrum
REQUIREMENT = {"quantity": "spectral_density_deviation", "limit": "3 dB"}


@dataclass(frozen=True)
class Shaken:
    """A record of a shaker.

    Parameters
    ----------
    recording : Recording
        As read.
    kind : {"random", "swept"}
        Of its vibration.
    controls : tuple of str
        Columns that may be its control: those named so; the one that vibrates most like one, where none is.
    named : bool
        They are named so.
    """

    recording: Recording
    kind: Kind
    controls: tuple[str, ...]
    named: bool

    @property
    def item(self) -> dict[str, Channel]:
        """Accelerometers by axis, that are no control."""
        found = accelerometers(self.recording)
        return {axis: one for axis, one in found.items() if one.name not in self.controls}

    @property
    def rides(self) -> bool:
        """Whether gyros ride on the table."""
        return bool(gyros(self.recording))

    @property
    def options(self) -> str:
        """What a command has to be told of the control."""
        return "" if self.named else f"--control {shlex.quote(bare_name(self.controls[0]))}"


def shaken(recording: Recording) -> Shaken | None:
    """Return what vibration a recording holds; None where it clearly holds none.

    Only columns in a unit of acceleration count, and those named as controls are.
    """
    interval = recording.sample_interval
    if interval is None or not interval > 0.0:
        return None
    named = named_controls(recording)
    found: dict[str, Kind] = {}
    for one in recording.channels:
        known = one.unit is not None and kind(one.unit) == "acceleration"
        wanted = known or (one.name in named and one.unit is None)
        if not wanted or one.data.dtype.kind not in "iuf" or len(one.data) > LONGEST:
            continue
        x = np.asarray(one.data, dtype=np.float64) * (factor(one.unit or "", "m/s^2") if known else 1.0)
        if (own := recognised(x, interval, known)) and (not named or one.name in named):
            found[one.name] = own
    if not found:
        return None
    first = next(iter(found)) if named else min(found, key=lambda name: _spread(recording.channel(name)))
    kinds = found[first]
    return Shaken(recording, kinds, tuple(named) or (first,), bool(named))


def _spread(channel: Channel) -> float:
    """Return how uneven a channel is over time and frequency: the control is the evenest."""
    x = np.asarray(channel.data, dtype=np.float64)
    parts = x[: len(x) // 64 * 64].reshape(-1, 64)
    power = np.mean(np.abs(np.fft.rfft(parts - parts.mean(axis=1, keepdims=True), axis=1)) ** 2, axis=0)[1:]
    return float(np.std(np.log(np.maximum(np.var(parts, axis=1), 1e-300))) + np.std(np.log(np.maximum(power, 1e-300))))


def profile_columns(names: Mapping[str, str | None]) -> bool:
    """Return whether columns, by name with their unit, are frequencies and densities of acceleration."""
    words = {bare_name(name).lower(): unit for name, unit in names.items()}
    frequency = [name for name, unit in words.items() if name in FREQUENCY and unit in (None, "Hz")]
    level = [unit for heading, unit in words.items() if heading.startswith(DENSITY)]
    return len(frequency) == 1 and any(unit and same_dimension(unit, "(m/s^2)^2/Hz") for unit in level)


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``vibration`` of a random run, ``vibration profile`` of a table of nodes."""
    if recording.sample_interval is None:
        columns = {one.name: one.unit for one in recording.channels}
        if len(recording) <= NODES and profile_columns(columns):
            return Suggestion(("vibration profile",), Strength.SURE, complete=True, in_campaign=True)
        return None
    one = shaken(recording)
    if one is None or one.kind != "random" or (one.rides and not one.item):
        return None
    return Suggestion(("vibration",), Strength.STEPPED, options=f"--profile FILE.csv {one.options}".strip())


def claims(file: FolderFile) -> Claim | None:
    """Claim a random run, and a profile."""
    if file.recording is None:
        table = file.table
        units = table.units or (None,) * len(table.names)
        if len(table) <= NODES and profile_columns(dict(zip(table.names, units, strict=False))):
            return Claim(Strength.SURE, lambda: (table, ()))
        return None
    one = shaken(file.recording)
    if one is None or one.kind != "random" or (one.rides and not one.item):
        return None
    return Claim(Strength.STEPPED, lambda: (one, ()))


def entries(
    runs: Mapping[str, Shaken], label: str
) -> tuple[dict[str, object], dict[str, object], list[tuple[str, Shaken]]]:
    """Return sensors, recordings, and names of the recordings, of accelerometers on a shaker, by file."""
    recordings: dict[str, object] = {}
    names: list[tuple[str, Shaken]] = []
    units = [one.recording.channel(name).unit for one in runs.values() for name in one.controls]
    for number, (file, one) in enumerate(runs.items(), 1):
        controls = {role: one.recording.channel(name) for role, name in zip(CONTROLS, one.controls, strict=False)}
        axes = one.item
        said: dict[str, object] = {}
        if not axes:  # the first control accelerometer is the sensor
            first, *others = controls.values()
            axis = first.axis if first.axis in AXES else "x"
            axes, said = {axis: first}, {"axis": axis}
            controls = dict(zip(CONTROLS[1:], others, strict=False))
        channels = {name: {"column": own.name, "unit": own.unit or "?"} for name, own in {**controls, **axes}.items()}
        entry = {name: own if own["unit"] != "?" and one.named else fill_in(own) for name, own in channels.items()}
        names.append((f"{label}{number}", one))
        recordings[names[-1][0]] = recording_table("item", file, one.recording, entry) | said
    return {"item": sensor_table("accelerometer", units)}, recordings, names


def draft(contents: Mapping[str, object]) -> Draft:
    """Return sensor, recordings and tests of runs, a test each; their profile is a file of the folder."""
    runs = {file: one for file, one in contents.items() if isinstance(one, Shaken)}
    profiles = [file for file, one in contents.items() if isinstance(one, Table)]
    if not runs:
        return Draft({}, {}, [], {}, example=False)
    sensors, recordings, names = entries(runs, "run")
    profile: object = profiles[0] if len(profiles) == 1 else fill_in(profiles[0] if profiles else "FILE.csv")
    tests = [{"id": f"vibration_{name}", "procedure": "vibration", "recordings": [name]} for name, _ in names]
    found = {name: {**dict(one), "profile": profile} for name, one in recordings.items() if isinstance(one, dict)}
    return Draft(sensors, found, tests, REQUIREMENT)


__all__ = ["Shaken", "claims", "draft", "entries", "profile_columns", "shaken", "suggests"]
