"""What a noun is given: a file, a Recording or an array, and what the caller says of it.

Every way in becomes a campaign document first: sensors, entries of recordings, a plan, as text. `described` says what a
recording of channels is, by names and units against the ``InputSpec`` of a procedure. Nothing is guessed: what is not
clear is asked for, all of it at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from ..core.errors import DataError, UsageError
from ..core.key import AXES, Kind
from ..core.settings import setting
from ..core.units import divide, kind, normalise, parse_quantity, same_dimension
from ..files.text.headers import UNNAMED, bare_name, full_name, is_set_point

if TYPE_CHECKING:
    from ..core.recording import Channel, Recording
    from ..core.remarks import Remark
    from ..files.text.table import Table
    from .protocol import InputSpec, Role

GROUP: dict[str, str] = {"gyro": "gyro", "accelerometer": "acc"}  # as units and columns are named by people
KIND_OF_UNIT: dict[str, str] = {"gyro": "angular_rate", "accelerometer": "acceleration"}
EXAMPLE = {"angular_rate": "deg/s", "acceleration": "m/s2", "temperature": "degC", "pressure": "Pa"}
PLURAL = {
    "column": "columns",
    "unit": "units",
    "standard": "standards",
    "window": "windows",
    "position": "positions",
}  # options that may be repeated, in Python
UNITS_OF = {"angular_rate": "deg/s, rad/s", "acceleration": "m/s2, g", "temperature": "degC, K", "pressure": "Pa, mbar"}
RAW = ("count", "voltage")
PER_VOLT = ("V/(rad/s)", "V/(m/s^2)")  # dimensions of scale factors in volts
SPOKEN = {"gyro": ("deg/s", "rad/s", "deg/h"), "accelerometer": ("m/s^2", "g", "mg", "ug")}


@dataclass(frozen=True)
class Said:
    """What every noun can be told of its recordings, their sensor, the site and the standards."""

    columns: Mapping[str, str] = setting(
        "Column of a channel: x=COLUMN, temperature=COLUMN; or a column to take. By default, the names decide.",
        dict[str, str], example="x=wx", option="column",
    )  # fmt: skip
    units: Mapping[str, str] = setting(
        "Unit of a column or group, or of the sensor's readings.", dict[str, str], example="gyro=deg/s", option="unit"
    )
    sensor: str | None = setting("Which sensors of the file: gyro or acc.", None, example="acc")
    sample_rate: float | None = setting("Samples per second, where the file has no time; or in its place.", None)
    time_column: str | None = setting("Name, or number from 1, of the column with the time.", None)
    start: str | None = setting(
        "Only from this time on: UTC, GMT day of year (2014/295/09:36:36), mission elapsed time, seconds.",
        None, option="from",
    )  # fmt: skip
    stop: str | None = setting("Only before this time, written like --from.", None, option="to")
    mission_start: str | None = setting("When mission elapsed time (DDD/HH:MM:SS) is zero, in UTC.", None)
    frame: str | None = setting("Axes of a PAD recording: data (as they are) or sensor (turned to them).", None)
    decimal: Literal["comma", "point"] | None = setting(
        "Decimal sign of a text; where not given, the file decides.", None
    )  # fmt: skip
    skip: int | None = setting("Lines of a text before its table; where not given, they are found.", None, least=0)
    dates: Literal["day-first", "month-first"] | None = setting(
        "Order of dates like 3/4/2024; where not given, the file decides.", None
    )
    topics: list[str] = setting(
        "Of a file with several sets of columns, which: topic, message, group, sheet, table.",
        list[str], example="/imu/data", option="topic",
    )  # fmt: skip
    averaging: str | None = setting(
        "What each sample is the mean of, where that is not the sample interval.", None, example="1 s"
    )
    one_run: bool = setting("All files are of one power-up; else each has its own.", False)
    chain: str | None = setting(
        "From counts to the unit of the sensor: a TOML file with the keys of a campaign's chain, or the table itself.",
        None, example='{ kind = "adc", lsb = "5 V / 4095", counts = [0, 4095] }',
    )  # fmt: skip
    lsb: str | None = setting("Voltage of one count of the converter.", None, example="5 V / 4095")
    counts: str | None = setting(
        "Lowest and highest code of the converter: readings at either end are left out.", None, example="0, 4095"
    )
    scale_factor: Mapping[str, str] = setting(
        "Nominal scale factor of the sensor, one for all axes or one each (x=...): readings in counts or volts become "
        "those of the sensor by it.", dict[str, str], example='"0.5 V/(deg/s)"',
    )  # fmt: skip
    reference: Mapping[str, str] = setting(
        "Voltage, or count, of a sensor without input, one for all axes or one each; channel: it was recorded.",
        dict[str, str], example='"2.5 V"',
    )  # fmt: skip
    gain: Mapping[str, float] = setting(
        "Gain of the amplifier between sensor and converter, one for all axes or one each.",
        dict[str, float], example="x=10",
    )  # fmt: skip
    input_range: str | None = setting("Largest input of the sensor.", None, example="5 deg/s", option="range")
    latitude: str | None = setting("Geodetic latitude of the site.", None, example="36.6 deg")
    gravity: str | None = setting("Gravity at the site.", None, example="9.799 m/s2")
    height: str | None = setting("Height of the site above sea level.", None, example="120 m")
    standards: Mapping[str, str] = setting(
        "Standard uncertainty of a standard; or the table that a campaign has of it.",
        dict[str, str],
        example='rate_table.rate="0.05 %"',
        option="standard",
    )
    like: str | None = setting(
        "Campaign folder: sensor, chain, channels, site, standards and plan as it has them for such a file.", None
    )


# Settings that say how a file is read: every command that reads recordings has them, from here.
READING = ("columns", "units", "sample_rate", "time_column", "start", "stop", "mission_start", "frame", "decimal",
           "skip", "dates", "topics")  # fmt: skip


@dataclass(frozen=True, eq=False)
class GivenFile:
    """One file, or one recording in memory, with all that was said.

    Parameters
    ----------
    name : str
        Path as typed, or ``"recording 1"``.
    said : Said
        Of all files.
    own : mapping of str to object
        What was said with the procedure's own options (``Procedure.said_type``), those that were given.
    plan : mapping of str to object
        Settings of the plan that were given.
    read, read_rows : callable
        The recording; its rows as a table.
    has_rows : bool
        It is a file, which has rows.
    options : bool
        The caller types options, not arguments of Python.
    number : int
        Of the file, from 1.
    together : sequence of GivenFile
        All files of the call.
    label : str
        What the caller calls it (``Procedure.split_label``).
    """

    name: str
    said: Said
    own: Mapping[str, Any]
    plan: Mapping[str, Any]
    read: Callable[..., Recording]
    read_rows: Callable[[], Table]
    has_rows: bool = True
    options: bool = True
    number: int = 1
    together: Sequence[GivenFile] = ()
    label: str = ""

    @property
    def names(self) -> list[str]:
        """Names of all files."""
        return [one.name for one in self.together]

    @cached_property
    def recording(self) -> Recording:
        """As its file has it."""
        return self.read()

    @cached_property
    def table(self) -> Table:
        """Its rows."""
        return self.read_rows()

    def add(self, option: str, example: str) -> str:
        """Return how the caller says a setting: ``--axis x``, or ``axis='x'``."""
        if self.options:
            quoted = f'"{example}"' if " " in example else example
            return f"--{option.replace('_', '-')} {quoted}"
        name, equals, value = example.partition("=")
        argument = PLURAL.get(option, option)
        return f"{argument}={{{name!r}: {value!r}}}" if equals else f"{argument}={example!r}"


@dataclass(frozen=True)
class Described:
    """What a file is taken for, as a campaign says it.

    Parameters
    ----------
    entry : dict
        Of the recording, without ``sensor`` and ``file``.
    sensor : dict
        ``kind``, ``axes``, ``unit``, ``chain``, ...
    columns : dict of str to str
        Which column is what, for people.
    plan : dict
        Settings that follow from it.
    windows : list of [str, str]
        Of the test.
    test : str
        Its id where each sensor has its own test; else all that is described is one test.
    remarks : tuple of Remark
        What a reader of the figures should know.
    requirements : list of dict
        What was asked of the figures, as a campaign has it.
    procedure : str
        Whose test it is, where that of the call is made of its result; ``plan`` is then that of this test.
    """

    entry: dict[str, Any]
    sensor: dict[str, Any]
    columns: dict[str, str]
    plan: dict[str, Any] = field(default_factory=dict[str, Any])
    windows: list[list[str]] = field(default_factory=list[list[str]])
    test: str = ""
    remarks: tuple[Remark, ...] = ()
    requirements: list[dict[str, Any]] = field(default_factory=list[dict[str, Any]])
    procedure: str = ""


def bare(named: Mapping[str, str]) -> str | None:
    """Return what was given without a name, as ``--unit deg/s``; None where nothing was."""
    return next((value for name, value in named.items() if name == value), None)


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return what a recording of channels is: which column is which channel, in which unit.

    Raises
    ------
    UsageError
        If that is not clear, or a unit is missing: all that is missing at once.
    """
    recording, columns = given.recording, given.said.columns
    sensor = sensor_kind(given, spec)
    roles = {name: one for one in spec.roles
             for name in (one.name, *(f"{one.name}_{axis}" for axis in AXES if one.by_axis))}  # fmt: skip
    chain = chain_said(given, sensor)
    voltages = ("reference", "temperature_reference") if chain.get("kind", "none") != "none" else ()
    known = [*AXES, *roles, *(f"{name}_{axis}" for name in voltages for axis in AXES), *voltages]
    if chain:
        known += [name for name in ("temperature", *(f"temperature_{axis}" for axis in AXES)) if name not in known]
    columns = _by_channel(recording, columns, known)
    if wrong := [what for what in columns if what not in known]:
        raise UsageError(f"column {wrong[0]!r}", do=f"There are: {', '.join(known)}", code="unknown_name")
    have = ", ".join(recording.names)
    axes = {axis: columns[axis] for axis in AXES if axis in columns} or _axes(recording, sensor)
    if not axes:
        what = f"{given.name}: cannot tell which column is which axis of the {sensor}; it has {have}"
        others = {one.name: one.kind or KIND_OF_UNIT[sensor] for one in spec.roles if one.required}
        do = nameless_advice(
            given, AXES, KIND_OF_UNIT[sensor], {name: others[name] for name in others if name not in columns}
        )
        raise UsageError(what, do=do or f"Add: {given.add('column', 'x=COLUMN')}", code="no_column")
    taken = axes | {what: name for what, name in columns.items() if what not in AXES}
    for name in columns.values():
        if len(several := [what for what, one in taken.items() if one == name]) > 1:
            what = f"{given.name}: column {name!r} is given for {' and '.join(several)}"
            raise UsageError(what, do="Each channel has its own column", code="duplicate_id")
    for role in spec.roles:
        if not any(what == role.name or what.startswith(f"{role.name}_") for what in taken):
            found = _of_role(recording, role, spec.roles, set(taken.values()))
            if role.required and not found:
                what = f"{given.name}: cannot tell which column is the {role.name}; it has {have}"
                apart = any(one.code == "other_topics" for one in recording.remarks)
                do = f"Add: {given.add('column', f'{role.name}=COLUMN')}"
                do += "; where another topic of the file holds it, name the topics of both" if apart else ""
                raise UsageError(what, do=do, code="no_column")
            taken |= found
    chain = chain_of_units(given, chain, [recording.channel(name).unit for name in axes.values()])
    first = recording.channel(next(iter(axes.values()))).unit
    finds_scale = spec.raw and not chain and first is not None and kind(first) in RAW
    raw = (kind(str(first)),) if finds_scale else raw_units(chain)
    taken |= reference_columns(given, chain, [*axes], taken)
    units = {what: recording.channel(name).unit or ("count" if "count" in raw else None)
             for what, name in taken.items()}  # fmt: skip
    wanted = {what: _kinds(what, roles.get(what), sensor, raw) for what in taken}
    bad = [what for what in taken if units[what] is None or kind(units[what] or "") not in wanted[what]]
    if bad:
        raise _no_unit(given, taken, wanted, bad, sensor)
    channels = {what: {"column": name, "unit": units[what]} for what, name in taken.items()}
    spoken = spoken_unit(sensor, chain) if raw and chain else str(units[next(iter(axes))])
    said = sensor_said(given, sensor, [*axes], spoken, chain)
    remarks = chain_remarks(given, chain, [units[axis] for axis in axes])
    return Described({"channels": channels}, said, taken, remarks=remarks)


def named_columns(recording: Recording, columns: Mapping[str, str]) -> dict[str, str]:
    """Return which column is what, by its full name: it may be given without the unit in brackets.

    Raises
    ------
    DataError
        ``wrong_column`` where there is no such column.
    """
    return {what: full_name(recording.names, name) or recording.channel(name).name for what, name in columns.items()}


def _by_channel(recording: Recording, columns: Mapping[str, str], known: Sequence[str]) -> dict[str, str]:
    """Return columns by channel: one given by its name alone is of the axis that it names, else of the first free."""
    full = named_columns(recording, columns)
    found = {what: name for what, name in full.items() if what in known or columns[what] != what}
    for what in (one for one in columns if one not in found):
        free = [one for one in (recording.channel(full[what]).axis, *AXES) if one in AXES and one not in found]
        found[free[0] if free else what] = full[what]
    return found


def sensor_kind(given: GivenFile, spec: InputSpec) -> Kind:
    """Return which sensors a file is of: as said, by the unit of a named column, else the first that it has.

    Raises
    ------
    UsageError
        If the procedure takes no such sensors.
    """
    words = {GROUP[one]: one for one in spec.kinds} | {one: one for one in spec.kinds}
    if given.said.sensor is not None:
        if given.said.sensor not in words:
            do = f"There are: {', '.join(dict.fromkeys(words))}"
            raise UsageError(f"sensor {given.said.sensor!r}", do=do, code="unknown_name")
        return words[given.said.sensor]
    recording = given.recording
    columns = {axis: name for axis, name in given.said.columns.items() if axis in AXES}
    named = [recording.channel(name).unit for name in named_columns(recording, columns).values()]
    for one in spec.kinds:
        if any(unit is not None and kind(unit) == KIND_OF_UNIT[one] for unit in named):
            return one
    there = {channel.quantity for channel in recording.channels if channel.axis in AXES}
    return next((one for one in spec.kinds if GROUP[one] in there), spec.kinds[0])


def chain_said(given: GivenFile, sensor: Kind | None = None) -> dict[str, Any]:
    """Return the chain that was said, as a campaign has it; empty where none was.

    Of values by name those of an axis, and that of the group of the sensor, are its own.

    Raises
    ------
    UsageError
        If the text is no TOML table, the file cannot be read, or two options say the same.
    """
    import tomllib  # noqa: PLC0415

    from ..files.source import load  # noqa: PLC0415

    said, text = given.said, given.said.chain
    chain: dict[str, Any] = {}
    if text is not None:
        try:
            inline = text.lstrip().startswith("{")
            chain = tomllib.loads(f"chain = {text}" if inline else load(text).data.decode())
            chain = chain.get("chain", chain)
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise UsageError(f"chain: not TOML: {error}", where="" if inline else text, code="not_toml") from None
    factors = given.own.get("scale_factor") or said.scale_factor
    own: dict[str, Any] = {
        "lsb": said.lsb, "counts": _codes(given, said.counts), "scale_factor": _of_sensor(factors, sensor),
        "reference": _of_sensor(said.reference, sensor), "gain": _of_sensor(said.gain, sensor),
    }  # fmt: skip
    own = {name: value for name, value in own.items() if value not in (None, "")}
    reference = own.get("reference")
    if isinstance(reference, Mapping) or _in_counts(reference):  # of each axis its own, or of a sensor without volts
        own["zero"] = own.pop("reference")
    if not chain and not own:
        return {}
    return {"kind": "adc" if "lsb" in chain | own else "output"} | chain | own


def _in_counts(text: object) -> bool:
    """Whether a quantity is in counts."""
    try:
        return kind(parse_quantity(str(text)).unit) == "count"
    except DataError:  # said where it is read
        return False


def chain_of_units(
    given: GivenFile, chain: Mapping[str, Any], units: Sequence[str | None], *, nominal: bool = False
) -> dict[str, Any]:
    """Return a chain as it goes with readings in these units; ``nominal``: its scale factor alone scales a result.

    Raises
    ------
    UsageError
        ``option_without_effect`` where they are in units of input already; ``no_scale_factor``.
    """
    kept = dict(chain)
    is_input = bool(units) and all(unit and kind(unit) in KIND_OF_UNIT.values() for unit in units)
    if kept.get("kind") in ("adc", "output") and is_input:
        if nominal and not kept.keys() - {"kind", "scale_factor"}:
            return kept | {"kind": "none"}
        if any(_has_raw(one) for one in given.together if one is not given):  # the chain is that of another file
            return {}
        idle = [name for name in ("lsb", "counts", "reference", "zero", "gain", "scale_factor") if name in kept]
        raise without_effect(given, "chain" if given.said.chain is not None else idle[0], units[0])
    if kept.get("kind") in ("adc", "output") and not kept.get("scale_factor"):
        volts = "V" if kept["kind"] == "adc" or "voltage" in {kind(unit) for unit in units if unit} else "count"
        what = f"{given.name}: counts and volts need the scale factor of the sensor"
        do = f"Add that of its data sheet: {given.add('scale_factor', f'NUMBER {volts}/(UNIT)')}"
        raise UsageError(what, do=do, code="no_scale_factor")
    return kept


def _has_raw(given: GivenFile) -> bool:
    """Whether a file has readings in counts or volts."""
    return any(one.unit and kind(one.unit) in RAW and (one.axis in AXES or one.quantity in GROUP.values())
               for one in given.recording.channels)  # fmt: skip


def reference_columns(
    given: GivenFile, chain: Mapping[str, Any], axes: Sequence[str], named: Mapping[str, str]
) -> dict[str, str]:
    """Return the columns of the reference voltages that a chain subtracts sample by sample, by what they are.

    Those that are named, those whose header is the word, and the recorder's (``x_ref``).

    Raises
    ------
    UsageError
        ``no_column`` where one is missing: all that are missing at once.
    """
    if chain.get("reference") != "channel":
        return {}
    names, found = given.recording.names, dict[str, str]()
    for what in ("reference", *(f"reference_{axis}" for axis in axes)):
        header = full_name(names, what) or full_name(names, f"{what[-1]}_ref")
        if column := named.get(what) or header:
            found[what] = column
    missing = [f"reference_{axis}" for axis in axes if not {"reference", f"reference_{axis}"} & set(found)]
    if missing:
        wanted = missing if found else ["reference"]
        what = f"{given.name}: cannot tell which column is the {' and the '.join(wanted)}; it has {', '.join(names)}"
        why = "the chain subtracts it sample by sample"
        do = f"Add: {' '.join(given.add('column', f'{one}=COLUMN') for one in wanted)}"
        raise UsageError(what, "", why, do, "no_column")
    return found


def without_effect(given: GivenFile, name: str, unit: str | None) -> UsageError:
    """Return the error of a part of the chain that is said of readings in units of input."""
    what = f"{given.name}: {name} is given, and the readings are in {unit} already"
    return UsageError(what, do="Leave it out, or correct the unit", code="option_without_effect")


def chain_remarks(given: GivenFile, chain: Mapping[str, Any], units: Sequence[str | None]) -> tuple[Remark, ...]:
    """Return a remark where volts are counted from 0 V, as nobody said what the sensor gives without input."""
    from ..core.remarks import Remark  # noqa: PLC0415

    volts = chain.get("kind") == "adc" or any(unit is not None and kind(unit) == "voltage" for unit in units)
    if not raw_units(chain) or not volts or "reference" in chain or "zero" in chain or given.said.chain is not None:
        return ()
    what = "voltage without input not given: taken as 0 V, all of it that is not is in the bias"
    return (Remark("no_reference", "warning", what, given.name, do=f"Add: {given.add('reference', 'NUMBER V')}"),)


def raw_units(chain: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the kinds of unit that a chain starts from; none of one that does nothing."""
    if chain.get("kind", "none") == "none":
        return ()
    given = chain.get("scale_factor")
    text = next(iter(given.values()), "") if isinstance(given, Mapping) else given
    volts = bool(text) and any(same_dimension(parse_quantity(str(text)).unit, one) for one in PER_VOLT)
    if chain["kind"] == "adc":
        return ("count", "voltage")
    if chain["kind"] == "pulse_rate":
        return ("count", kind("count/s"))
    return ("voltage",) if chain["kind"] == "output" and volts else ("count",)


def raw_advice(given: GivenFile, units: Sequence[str | None], like: str = "UNIT") -> str:
    """Return what to add to readings in counts or volts: numbers of the data sheet, none of which is invented."""
    per, zero = f"/({like})" if "/" in like else f"/{like}", given.add("reference", "NUMBER V")
    volts = given.add("scale_factor", f"NUMBER V{per}")
    if all(unit is not None and kind(unit) == "voltage" for unit in units):
        return f"Add of the data sheet: {volts} {zero}"
    lsb, own = given.add("lsb", "NUMBER V"), given.add("scale_factor", f"NUMBER count{per}")
    return f"Add of the data sheet, behind a converter: {lsb} {zero} {volts}; of a digital sensor: {own}"


def _codes(given: GivenFile, text: str | None) -> list[int] | None:
    if text is None:
        return None
    parts = text.strip("[] ").replace(",", " ").replace("..", " ").split()
    try:
        lowest, highest = (int(one) for one in parts)
    except ValueError:
        what = f"{given.add('counts', text)}: need the lowest and the highest code"
        raise UsageError(what, do=f"Write it like {given.add('counts', '0, 4095')}", code="wrong_value") from None
    return [lowest, highest]


def _of_sensor(values: Mapping[str, Any], sensor: Kind | None) -> Any:
    """Return what was given for a sensor: one value for all axes, or one each; None where there is none."""
    if not values:
        return None
    group = values.get(sensor or "", values.get(GROUP.get(sensor or "", ""), bare(values)))
    by_axis = {axis: values[axis] for axis in AXES if axis in values}
    return by_axis or group


def own_clock(given: GivenFile, sensor: str) -> dict[str, Any]:
    """Return the column of the stamps of this sensor, as an entry has it, where sensors of a file have their own."""
    from ..files.text.headers import sensor_of_stamps  # noqa: PLC0415 - files start slowly

    recording = given.recording
    times = [c.name for c in recording.channels if c.quantity == "time"]
    times += [recording.time_column] if recording.time_column else []
    by_sensor = {name: sensor_of_stamps(name) for name in times}
    if given.said.time_column is not None or not any(by_sensor.values()):
        return {}
    own = [name for name in times if by_sensor[name] == GROUP.get(sensor)] or [
        name for name in times if not by_sensor[name]
    ]
    return {"clock": {"column": own[0]}} if len(own) == 1 and own[0] != recording.time_column else {}


def sensor_said(
    given: GivenFile, sensor: Kind, axes: Sequence[str], unit: str, chain: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Return a sensor as a campaign has it; ``chain``: as it goes with its readings, else as said."""
    said: dict[str, Any] = {"kind": sensor, "axes": list(axes), "unit": unit}
    if given.said.input_range is not None:
        largest = given.said.input_range
        said["range"] = [f"-{largest.lstrip('+-')}", largest.lstrip("+-")]
    chain = chain_said(given, sensor) if chain is None else chain
    return said | ({"chain": dict(chain)} if chain else {})


def spoken_unit(sensor: Kind, chain: Mapping[str, Any]) -> str:
    """Return the unit that people speak of a sensor in counts: that of its scale factor."""
    given = chain.get("scale_factor")
    text = next(iter(given.values())) if isinstance(given, Mapping) and given else given
    if text:
        unit = parse_quantity(str(text)).unit
        for one in SPOKEN[sensor]:
            if unit in {divide(volts, one) for volts in ("V", "mV", "count", "count/s")}:
                return normalise(one)
    return normalise(SPOKEN[sensor][0])


def _axes(recording: Recording, sensor: Kind) -> dict[str, str]:
    lettered = [one for one in recording.channels if one.axis in AXES]
    own = [one for one in lettered if one.quantity == GROUP[sensor]]
    found = own or [one for one in lettered if not one.quantity]
    named = {one.axis: one.name for one in found}
    return named if len(named) == len(found) else {}


def _kinds(what: str, role: Role | None, sensor: Kind, raw: tuple[str, ...]) -> tuple[str, ...]:
    """Return the kinds of unit that a channel may have."""
    if what in AXES:
        return raw or (KIND_OF_UNIT[sensor],)
    own = (raw or ("count",)) if role is None else (role.kind or KIND_OF_UNIT[sensor],)
    return (*own, *raw) if what.startswith("temperature") else own


def _of_role(recording: Recording, role: Role, roles: Sequence[Role], used: Set[str]) -> dict[str, str]:
    """Return the one channel of a role's quantity, or that of each axis, which nothing else has.

    Of several roles of one quantity only the first is guessed: the others are columns of their name.
    """
    alike = [one.name for one in roles if one.kind == role.kind]
    left = [one for one in recording.channels if one.quantity == role.kind and one.name not in used]
    own = [one for one in left if bare_name(one.name) == role.name]
    if role.name != alike[0]:
        return {role.name: own[0].name} if len(own) == 1 else {}
    found = [one for one in left if bare_name(one.name) not in alike[1:]]
    found = [one for one in found if not is_set_point(one.name)] or found
    if len(found) == 1:
        return {role.name: found[0].name}
    by_axis = {f"{role.name}_{one.axis}": one.name for one in found if one.axis in AXES}
    return by_axis if len(by_axis) == len(found) else {}


def _no_unit(
    given: GivenFile, taken: Mapping[str, str], wanted: Mapping[str, Sequence[str]], bad: Sequence[str], sensor: Kind
) -> UsageError:
    """Return the error of channels without a unit that fits: what is in counts or volts needs the chain."""
    channels = {taken[what]: given.recording.channel(taken[what]) for what in bad}
    names = ", ".join(f"{name!r} ({one.unit or '?'})" for name, one in channels.items())
    what = f"{given.name}: unit missing or of the wrong kind: {names}"
    alternating = [one.name for one in channels.values() if one.unit is not None and same_dimension(one.unit, "VAC")]
    if alternating:
        why = "the level of an alternating voltage has no sign: it is not what a sensor puts out"
        return UsageError(what, "", why, "Record it as DC voltage", "no_unit")
    axes = [one for name, one in channels.items() if name in {taken[what] for what in bad if what in AXES}]
    raw = [one for one in axes if one.unit is not None and kind(one.unit) in RAW]
    unsaid = [what for what in bad if given.recording.channel(taken[what]) not in raw]
    named: dict[str, tuple[str, list[Channel]]] = {}
    for role in unsaid:
        one = given.recording.channel(taken[role])
        known = role in (one.quantity, bare_name(one.name))
        group = GROUP[sensor] if role in AXES else role if known else bare_name(one.name)
        named.setdefault(group, (wanted[role][0], []))[1].append(one)
    do = [raw_advice(given, [one.unit for one in raw], EXAMPLE[KIND_OF_UNIT[sensor]])] if raw else []
    do += unit_advice(given, named)
    return UsageError(
        what, "", "counts and volts need the chain of the sensor" if raw else "", ". ".join(do), "no_unit"
    )


def nameless_advice(given: GivenFile, readings: Sequence[str], wanted: str, others: Mapping[str, str]) -> str:
    """Return all that is to be said of a file none of whose columns has a name; empty where one has.

    ``wanted``: kind of unit of the readings; ``others``: that of each other column.
    """
    if not all(UNNAMED.fullmatch(name) for name in given.recording.names):
        return ""
    columns = " ".join(given.add("column", f"{one}=COLUMN") for one in (*readings, *others))
    units = " ".join([given.add("unit", "UNIT"), *(given.add("unit", f"{one}=UNIT") for one in others)])
    notes = [f"COLUMN: a name or its number; UNIT: {UNITS_OF.get(wanted, wanted)}, ..."]
    notes += [f"UNIT of {one}: {UNITS_OF.get(unit, unit)}, ..." for one, unit in others.items()]
    return f"Add: {columns} {units} ({'; '.join(notes)})"


def unit_advice(given: GivenFile, named: Mapping[str, tuple[str, Sequence[Channel]]]) -> list[str]:
    """Return what to add to channels without a unit that fits: what numbers give away, else which units there are.

    ``named``: kind of unit that is wanted, and the channels, by the name that the option takes.
    """
    options, notes, others = list[str](), list[str](), list[str]()
    for name, (wanted, channels) in named.items():
        unit, reason = _hint(given, channels)
        if unit == "count":
            others.append(f"Counts? ({reason}) {raw_advice(given, ['count'], EXAMPLE.get(wanted, 'UNIT'))}")
            continue
        known = bool(unit) and kind(unit) == wanted
        options.append(given.add("unit", f"{name}={unit if known else 'UNIT'}"))
        like = UNITS_OF.get(wanted, EXAMPLE.get(wanted, wanted))
        notes.append(reason if known else f"UNIT of {name}: {like}, ...")
    return [*([f"Add: {' '.join(options)} ({'; '.join(notes)})"] if options else []), *others]


def _hint(given: GivenFile, channels: Sequence[Channel]) -> tuple[str, str]:
    """Return the unit that numbers give away, and why; empty where they do not."""
    from ..files.info.channel_survey import unit_hints  # noqa: PLC0415 - starts slowly

    named = [one for one in channels if one.unit is None]
    hints = unit_hints(replace(given.recording, channels=tuple(named)))
    return next(((one.unit, one.reason) for one in hints if one.unit), ("", ""))
