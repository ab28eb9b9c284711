"""What looks like a unit laid by hand: the command to type next, a draft of the tests."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...core.batches import extremes
from ...core.campaign_text import Noted
from ...core.errors import InertialcalError
from ...core.key import AXES
from ...core.recording import Channel, Recording
from ...core.units import factor, kind
from ...files import read
from ...files.info.motion import accelerometers, gyros, is_laid, triad
from ...files.info.survey import Survey
from ...files.text.headers import heading
from ...files.text.table import Table
from ..given import GivenFile, Said
from ..suggestions import (
    Claim,
    Draft,
    FolderFile,
    Question,
    Strength,
    Suggestion,
    channel_tables,
    fill_in,
    quantity,
    recording_table,
    sensor_table,
)
from .given import LONGEST as LONGEST_TABLE
from .given import applied_columns, is_table_of_positions, rests_of_table
from .orientations import HOW_IT_LAY

SENSORS = {"acc": ("accelerometer", "acceleration"), "gyro": ("gyro", "angular_rate")}
REQUIREMENT = {"quantity": "transition_error", "upper": "0.5 deg"}
LONGEST = 4_000_000  # samples of a record whose dwells are looked for before it is asked for
GRAVITY = 0.5  # least that an axis feels of it, in any position of a triad [g]


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``positions`` where a triad of accelerometers was laid into many positions, and feels gravity."""
    if is_table_of_positions(recording) and (applied_columns(recording.channels) or _is_labelled(recording, survey)):
        units = [f"--unit {one.target}={one.unit}" for one in survey.hints if one.unit]
        return Suggestion(("positions",), Strength.SURE, options=" ".join(units))
    if not any(remark.code == "not_at_rest" for remark in survey.remarks):
        return None
    own = accelerometers(recording)
    if len(own) != len(AXES):
        return None
    sizes = [max(map(abs, extremes(one.data))) * factor(one.unit or "", "g") for one in triad(recording)]
    felt = max(sizes) > GRAVITY if len(sizes) == len(own) else all(one.unit for one in own.values())  # counts, volts
    laid = felt and (len(recording) > LONGEST or is_laid(recording))
    return Suggestion(("positions",), Strength.POSSIBLE) if laid else None


def _is_labelled(recording: Recording, survey: Survey) -> bool:
    """Whether a file looks like means of positions, by its columns: a triad of accelerometers, and how it lay."""
    names = {one.subject.lower() for one in survey.remarks if one.code == "text_column"}
    return len(accelerometers(recording)) == len(AXES) and bool(names & set(HOW_IT_LAY))


def claims(file: FolderFile) -> Claim | None:
    """Claim a recording in many orientations that says no rate that was applied, and gyros recorded beside it.

    So it does a table that says how each row lay.
    """
    recording, rates = file.recording, file.columns.applied
    if recording is None:
        rests = {} if rates else _rests(file.table)
        return Claim(Strength.SURE, lambda: (rests, ())) if rests else None
    if rates:
        return None
    laid = is_laid(recording) or (bool(gyros(recording)) and any(map(is_laid, file.beside)))
    return Claim(Strength.LIKELY, lambda: (recording, ())) if laid else None


def _rests(table: Table) -> dict[str, dict[str, Any]]:
    """Return the columns of a table of positions; nothing of any other file."""
    if table.sampled or len(table) > LONGEST_TABLE or sum(heading(one).axis != "" for one in table.names) < len(AXES):
        return {}
    path = table.source.path
    try:
        return rests_of_table(GivenFile(path, Said(), {}, {}, lambda: read(path), lambda: table))
    except InertialcalError:
        return {}


def asks(contents: Mapping[str, object]) -> list[Question]:
    """Return the question how large gravity is: standard gravity is a suggestion, which people mend who know better."""
    seen = f"{', '.join(contents)}: laid by hand, with gravity as the reference"
    return [Question("gravity", seen, "Gravity at the site?", "9.80665 m/s2", wrong=quantity("m/s^2"))]


def draft(contents: Mapping[str, object]) -> Draft:
    """Return sensors, recordings and tests of a unit that was laid by hand, by file."""
    recordings = {file: one for file, one in contents.items() if isinstance(one, Recording)}
    channels: dict[str, dict[str, dict[str, Channel]]] = {sensor: {} for sensor in SENSORS}
    together: dict[str, list[str]] = {}  # of one file: gyros and accelerometers may be apart in it
    for file, one in recordings.items():
        together.setdefault(one.source.path or file, []).append(file)
        for sensor, own in (("acc", accelerometers(one)), ("gyro", gyros(one))):
            channels[sensor] |= {file: own} if len(own) == len(AXES) else {}
    have = [sensor for sensor, own in channels.items() if together and all(any(file in own for file in one)
                                                              for one in together.values())]  # fmt: skip
    sensors = {}
    for sensor in have:
        word, quantity = SENSORS[sensor]
        said = [c.unit for by_axis in channels[sensor].values() for c in by_axis.values()]
        units = [unit for unit in said if unit and kind(unit) == quantity]
        chain = {"kind": "adc", "lsb": "...", "counts": [0, 65535], "scale_factor": "..."}
        sensors[sensor] = sensor_table(word, units) | {"chain": Noted(chain, example=True)}
    numbered = dict(enumerate(together.values(), 1))
    entries = {
        f"{sensor}_hand{number}": recording_table(sensor, file, recordings[file], channel_tables(own))
        for number, files in numbered.items()
        for sensor in have
        for file, own in channels[sensor].items()
        if file in files
    }
    numbers = list(numbered)
    held = numbers[-1:] if len(numbers) > 1 else []  # of several recordings the last is held out
    tests = [
        {
            "id": name,
            "procedure": "positions",
            "recordings": [f"{sensor}_hand{number}" for number in own for sensor in have],
            "use": use,
        }
        for name, use, own in (("imu", "fit", numbers[: len(numbers) - len(held)]), ("imu_held_out", "hold_out", held))
        if own and have
    ]
    tables = [(file, one) for file, one in contents.items() if isinstance(one, Mapping)]
    for number, (file, table) in enumerate(tables, 1):
        for sensor, rests in table.items():
            word, quantity = SENSORS[sensor]
            unit = str(rests["unit"])
            known = [unit] if unit != "?" and kind(unit) == quantity else []
            sensors.setdefault(sensor, sensor_table(word, known))
            columns = fill_in(rests) if unit == "?" else rests
            entries[f"{sensor}_faces{number}"] = {"sensor": sensor, "file": file, "rests": columns}
        names = [f"{sensor}_faces{number}" for sensor in table]
        tests.append({"id": f"faces{number}", "procedure": "positions", "recordings": names, "use": "fit"})
    site = {
        "latitude": Noted("48 deg", example=True),
        "height": Noted("300 m", example=True),
        "gravity": fill_in("9.80665 m/s2"),
    }
    standards = {
        "gravity": Noted({"value": {"u": "0.001 m/s2", "certificate": "..."}}, example=True),
        "clock": Noted({"rate": {"u": "50 ppm", "certificate": "..."}}, example=True),
    }
    return Draft(sensors, entries, tests, REQUIREMENT, standards, site)
