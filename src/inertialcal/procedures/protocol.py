"""What a procedure is: one object that says all the engine needs, with defaults for what is not its own.

The engine (run, check, init, score, compare, report, commands) names no procedure: it asks the object. A procedure is
one folder, `procedures/<name>/`, whose ``procedure.py`` holds the object; ``plan.py`` and this module import nothing
that starts slowly, as options and help are made of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Generic, Literal, NamedTuple, Protocol, TypeVar

from ..core.errors import InertialcalError
from ..core.figure import FigureSpec
from ..core.influence import Occasion, Selection
from ..core.key import AXES, Kind
from ..core.results import WrittenRow
from ..core.show.rows import Compared, Sentence, error_sentence

if TYPE_CHECKING:
    from pathlib import Path

    from ..core.curve import Curve
    from ..core.errors import Problem
    from ..core.estimate import Array, Estimate
    from ..core.influence import Influence, Standards
    from ..core.judging import Asked, Verdict
    from ..core.key import Key, Origin
    from ..core.recording import Recording
    from ..core.remarks import Remark
    from ..core.results import Interval, Row
    from ..core.show.tables import Block
    from ..core.unknowns import Unknowns
    from ..files.info.survey import Survey
    from ..files.text.table import Table
    from ..sensors.model.sensor_model import SensorModel
    from .entries import Entry, EntryKey, SaidSensor, SaidTest
    from .given import Described, GivenFile
    from .model_terms import HeldOut, ModelTerms, TermKind
    from .rehearsed import Rehearsal
    from .suggestions import Claim, Draft, FolderFile, Question, Suggestion

T = TypeVar("T")


@dataclass(frozen=True)
class Role:
    """A channel that a procedure reads besides the axes.

    Parameters
    ----------
    name, kind, unit : str
        As entries call it; kind of unit, empty for that of the sensor; unit inside.
    required : bool
        Whether a recording must have it.
    by_axis : bool
        ``name_x``, ... may stand in place of one for all.
    """

    name: str
    kind: str
    unit: str
    required: bool = False
    by_axis: bool = True


@dataclass(frozen=True)
class InputSpec:
    """What a procedure takes, and how its recordings are made ready for it.

    Parameters
    ----------
    kinds : tuple of str
        Of sensors; the one that is taken first where a file has several.
    roles : tuple of Role
        Channels besides the axes.
    table : str
        Key of its reduced tables in an entry; empty where it reads recordings only.
    missing : bool
        A literal NaN is a missing sample; refused otherwise.
    as_wide : bool
        Readings of 32 bits stay 32 bits wide.
    streamed : bool
        Readings longer than memory are worked on a batch at a time.
    bare : bool
        Sensors of no known kind, in the unit of the file, and samples that are increments or their sum are taken.
    ground_model : {"refused", "bias_kept", "applied"}
        Of the chain.
    voltages : bool
        Whether the reference voltages of the sensors are wanted.
    windows : {"mask", "records", "refused"}
        Samples in any window are one recording; or each window is a record of its own.
    by_body : bool
        Channels of one sensor each (temperatures, reference voltages) are named by the body axis that it feels.
    several_sensors : bool
        A test may hold recordings of several sensors of one clock.
    pulses : bool
        Pulses may come without a scale factor: it is what the test finds.
    raw : bool
        Sensors may be in counts or volts without a chain: the procedure finds their scale factors.
    screening : {"at_rest", "moving", "own"}
        How the gate looks axes through before the procedure sees them: steps, changes of the noise and waves count in
        records at rest only; ``"own"`` leaves it to the procedure.
    still : bool
        The sensor is not moved, though its level may drift: a jump of its readings is no motion.
    """

    kinds: tuple[Kind, ...]
    roles: tuple[Role, ...] = ()
    table: str = ""
    missing: bool = False
    as_wide: bool = False
    streamed: bool = False
    bare: bool = False
    ground_model: Literal["refused", "bias_kept", "applied"] = "refused"
    voltages: bool = False
    windows: Literal["mask", "records", "refused"] = "mask"
    by_body: bool = False
    several_sensors: bool = False
    pulses: bool = False
    raw: bool = False
    screening: Literal["at_rest", "moving", "own"] = "moving"
    still: bool = False


@dataclass(frozen=True)
class Facts:
    """What is known before any reading: of the sensor, the site, the standards. Fields of a Plan ``from`` it.

    Parameters
    ----------
    kind : {"gyro", "accelerometer"} or None
        Of the sensor.
    unit, si : str
        That people speak (``"deg/s"``), and that of readings inside.
    axes : tuple of str
        Of the sensor.
    latitude, gravity, height : float or None
        Of the site [rad], [m/s^2], [m].
    standards : mapping of Influence
        By ``"standard.quantity"``.
    scale_factor : mapping of str to float, optional
        Ideal scale factor behind each body axis [V/SI].
    thermometers : mapping of str to (float, float, float), optional
        By body axis: slope [V/degC], voltage [V], temperature [degC].
    input_range : (float, float), optional
        Of the sensor, SI.
    gate : float or None
        Of a chain that counts pulses [s].
    output_unit : str
        Of what leaves the sensor: ``count/s``, ``V``, ``count``; SI where readings are in units of input.
    output_scale_factor : float or None
        Of the data sheet, of the first axis [output unit/SI unit of input]; None where not stated.
    oblique : bool
        Body axes are mixtures of the sensor's.
    cut_off : float or None
        Of the sensor's low pass [Hz].
    others : tuple of Facts
        What is known of the other sensors of the test.
    """

    kind: Kind | None
    unit: str
    si: str
    axes: tuple[str, ...] = AXES
    latitude: float | None = None
    gravity: float | None = None
    height: float | None = None
    standards: Standards = field(default_factory=dict[str, "Influence"])
    scale_factor: Mapping[str, float] | None = None
    thermometers: Mapping[str, tuple[float, float, float]] | None = None
    input_range: tuple[float, float] | None = None
    gate: float | None = None
    output_unit: str = ""
    output_scale_factor: float | None = None
    oblique: bool = False
    cut_off: float | None = None
    others: tuple[Facts, ...] = ()


class Source(Protocol):
    """A recording or reduced table with its sensor, ready: SI, body axes, named by role. One class, over a store."""

    @property
    def name(self) -> str:
        """As the campaign calls it."""
        ...

    @property
    def file(self) -> str:
        """Its file, as the campaign names it."""
        ...

    @property
    def run(self) -> str:
        """Power-up; empty where not said."""
        ...

    @property
    def facts(self) -> Facts:
        """Of its sensor."""
        ...

    @property
    def test(self) -> str:
        """Name of the test that reads it."""
        ...

    @property
    def alone(self) -> bool:
        """Whether the test reads no other."""
        ...

    @property
    def groups(self) -> Sequence[str] | None:
        """Rows of a table that the test takes, by their group; None for all."""
        ...

    @property
    def windows(self) -> Sequence[tuple[int, int]] | None:
        """Instants [ns] between which the test takes readings; None for all."""
        ...

    @property
    def entry(self) -> Entry:
        """What is said of it; a procedure casts it to the protocol of its own keys (``entry.py``)."""
        ...

    @property
    def is_table(self) -> bool:
        """Whether it is a reduced table."""
        ...

    @property
    def ground(self) -> SensorModel | None:
        """Ground model that a file of the chain gives; None where there is none."""
        ...

    @property
    def screening(self) -> bool:
        """Whether samples that are no readings are left out; False where figures are made with them, to compare."""
        ...

    @property
    def remarks(self) -> Sequence[Remark]:
        """What looking its recording through brought up; empty before it is read."""
        ...

    def recordings(self) -> list[tuple[str, Recording]]:
        """Return each part with its label: the whole, or a record a window."""
        ...

    def table(self) -> Table:
        """Return the reduced table."""
        ...

    def chose(self, rows: int, without_rate: int = 0) -> None:
        """Note how many rows of a table the test uses, and how many have no applied rate."""
        ...

    def in_si(self, values: Array, unit: str, axis: str) -> Array:
        """Return readings of a table in SI: counts through the chain, volts over the scale factor."""
        ...

    def all_in_si(self, values: Array, unit: str, axes: Sequence[str]) -> Array:
        """Return the same of several axes, shape (k, n)."""
        ...

    def factor(self, unit: str, axis: str) -> float:
        """Return SI units a unit of the table, for differences."""
        ...

    def has(self, file: str) -> bool:
        """Return whether there is such a file."""
        ...

    def read_file(self, file: str, read: Callable[[Any], T]) -> T:
        """Return what another file says of it (a schedule, sections), read and counted among the inputs."""
        ...


class WithRemarks(Protocol):
    """Readings: frozen dataclasses that carry what reading them brought up."""

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """Findings."""
        ...


class Result(WithRemarks, Protocol):
    """What a test found about one sensor."""

    @property
    def estimate(self) -> Estimate | None:
        """Its values, SI; None where each stands in its row alone, or where nothing could be told."""
        ...

    def rows(self) -> Sequence[Row]:
        """Return the rows of ``results.json``, SI."""
        ...


P = TypeVar("P")
R = TypeVar("R", bound="WithRemarks | None")
S = TypeVar("S", bound=Result)


class Reduced(Protocol):
    """What a noun found in its files, as commands and plots see it."""

    @property
    def word(self) -> str:
        """The command: a procedure may have several."""
        ...

    @property
    def rows(self) -> Sequence[Row]:
        """The figures, in the unit of the sensor."""
        ...

    @property
    def tested(self) -> Sequence[Tested[Any, Any, Any]]:
        """Its tests, SI."""
        ...

    @property
    def models(self) -> Mapping[str, SensorModel]:
        """Models by kind of sensor."""
        ...

    def write_models(self, path: Path) -> list[Path]:
        """Write the models; return their paths."""
        ...

    def exported(self, to: str) -> tuple[str, tuple[Remark, ...]]:
        """Return the models in a format for others, and what it cannot hold."""
        ...

    @property
    def results(self) -> Mapping[str, Any]:
        """Content of ``results.json``."""
        ...

    @property
    def result(self) -> Any:
        """Of the procedure, SI."""
        ...

    @property
    def plan(self) -> Any:
        """Of the procedure."""
        ...

    @property
    def inputs(self) -> Mapping[str, str]:
        """SHA-256 by path."""
        ...

    @property
    def verdicts(self) -> Sequence[Mapping[str, Any]]:
        """On what was asked of the figures, as ``results.json`` has them."""
        ...

    @property
    def columns(self) -> Mapping[str, str]:
        """Which column was taken for what."""
        ...

    @property
    def remarks(self) -> Sequence[Remark]:
        """What reading and reducing brought up."""
        ...

    @property
    def unit(self) -> str:
        """Of the readings."""
        ...

    @property
    def shown(self) -> Any:
        """Settings of what is shown (``Procedure.shown_type``)."""
        ...


class Planned(Protocol):
    """What a test will give, before it is made."""

    @property
    def remarks(self) -> Sequence[Remark]:
        """What there is to say of the plan."""
        ...

    @property
    def results(self) -> Mapping[str, Any]:
        """``results`` and ``curves`` as ``results.json`` has them, and what else ``--json`` prints."""
        ...

    def parts(self) -> Sequence[Block]:
        """Return what is shown."""
        ...


class Correction(Protocol):
    """What a later test takes off its recordings: all at once, since its unknowns are common to them."""

    @property
    def test(self) -> str:
        """That found it."""
        ...

    @property
    def unit(self) -> str:
        """Of the readings that it is taken off: ``"rad/s"`` or ``"m/s^2"``."""
        ...

    @property
    def reference_temperature(self) -> float | None:
        """At which readings keep their bias where only its change is taken off [degC]; None: all of it is taken off."""
        ...

    def apply(
        self, recordings: Sequence[tuple[str, Recording]]
    ) -> tuple[list[Recording], list[Mapping[Origin, Unknowns]]]:
        """Return named recordings with it taken off, and for each what is not known of it, by origin.

        The unknowns of an origin are the same ones, in one order, whatever the recordings.
        """
        ...


class Command(NamedTuple):
    """A noun of the command line, or of ``plan``."""

    word: str  # As it is typed: one word, or two of which the first is a noun too
    help: str  # One line
    figure: str = ""  # That it draws by default
    examples: tuple[str, ...] = ()  # What may follow the word, for its help

    @property
    def function(self) -> str:
        """As Python calls it."""
        return self.word.replace("-", "_").replace(" ", "_")


@dataclass(frozen=True)
class Exclusion:
    """What a test did not use; the engine adds the name of the test.

    Parameters
    ----------
    rule, decided_by, reason : str
        Its code; which setting, with its value; why.
    place, axis : str
        Where; of which sensor.
    count, counts : int, str
        How many of what: ``dwell``, ``row``, ``sample``, ``window``.
    applied, unit : float or None, str
        Applied rate of a dwell.
    dwell : bool
        Whether it counts among the dwells that the test left out.
    """

    rule: str
    decided_by: str
    reason: str
    place: str = ""
    axis: str = ""
    count: int = 1
    counts: str = "dwell"
    applied: float | None = None
    unit: str = ""
    dwell: bool = False


READING = ("angular_rate", "acceleration")  # kinds of unit
RELATIVE = ("dimensionless",)
OF_MOUNTING = ("mounting",)  # angles in the fixture: another power-up leaves them as they are
LASTS: tuple[str, ...] = ()  # noise and scatter: neither a power-up nor a mounting draws them anew


@dataclass(frozen=True)
class Quantity:
    """What a procedure says of one of its figures: requirements, tables and comparisons read it here.

    Parameters
    ----------
    kinds : tuple of str
        Of unit that it can have; empty where ``shown_by_kind`` says it.
    over : str
        What a requirement on it may say ``where`` of: ``rate``, ``temperature``; empty for a single figure.
    size : bool
        Never negative: a limit is one above, and it is judged by its own interval.
    unit : str
        SI, that limits are shown in where no test speaks to it; empty where that is of the sensor.
    shown : str
        Unit that people speak, with ``{unit}`` for that of the sensor; empty for that of the sensor.
    shown_by_kind : mapping of str to str
        The same by kind of sensor.
    redrawn_by : tuple of str
        What draws it anew between two tests, though the unit is the same: another ``"power_up"``, another
        ``"mounting"``. A change of it is known no better than these are; None where no change of it is told.
    """

    kinds: tuple[str, ...] = ()
    over: str = ""
    size: bool = False
    unit: str = ""
    shown: str = ""
    shown_by_kind: Mapping[str, str] = field(default_factory=dict[str, str])
    redrawn_by: tuple[str, ...] | None = ("power_up",)

    def joined(self, other: Quantity) -> Quantity:
        """Return what both say: what this one leaves open is as the other has it."""
        return Quantity(
            tuple(dict.fromkeys((*self.kinds, *other.kinds))),
            self.over or other.over,
            self.size or other.size,
            self.unit or other.unit,
            self.shown or other.shown,
            {**other.shown_by_kind, **self.shown_by_kind},
            self.redrawn_by,
        )


@dataclass(frozen=True)
class BudgetFigure:
    """A figure whose sources of uncertainty are listed: ``times`` value ``at`` of the estimate.

    Parameters
    ----------
    key : Key
        As rows have it.
    unit : str
        SI.
    at : int
        In the estimate.
    times : float
        Factor.
    """

    key: Key
    unit: str
    at: int
    times: float = 1.0


def budget_figures(estimate: Estimate, keys: Sequence[Key] = ()) -> list[BudgetFigure]:
    """Return a figure for each value of an estimate, by its own key or by those given.

    Values at a place are left out: they have the sources of the coefficients that they are made of.
    """
    each = zip(keys or estimate.keys, estimate.units, strict=True)
    return [BudgetFigure(key, unit, at) for at, (key, unit) in enumerate(each) if key.at is None]


@dataclass(frozen=True)
class Levels:
    """Figures that mean nothing but by their change, SI, with the scatter between power-ups where they have a u.

    ``influences`` are those of their ``shared`` that no certificate states, as the direction of gravity in a mounting.
    """

    rows: Sequence[Row] = ()
    influences: Mapping[str, Influence] = field(default_factory=dict[str, "Influence"])


@dataclass(frozen=True, eq=False)
class Tested(Generic[P, R, S]):
    """A test that was reduced.

    Parameters
    ----------
    id, condition, use : str
        As the campaign says.
    plan, readings, result
        Of the procedure.
    recordings, files : tuple of str
        That it reads: names in the campaign, and paths of all files.
    facts : Facts
        Of its sensor.
    against : Tested or None
        The test that it is set beside.
    occasion : Occasion
        What drew the errors of standards in it.
    selection : Selection
        What it takes of its recordings.
    """

    id: str
    condition: str
    use: str
    plan: P
    readings: R
    result: S
    recordings: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    facts: Facts = Facts(None, "", "")
    against: Tested[Any, Any, Any] | None = None
    occasion: Occasion = field(default_factory=Occasion)
    selection: Selection = field(default_factory=Selection)


class Procedure(Generic[P, R, S]):
    """A test that turns readings into a result. Subclasses say what is their own; the rest has its default here.

    ``name`` is the word of campaign files, ``kind_of_test`` what a sentence calls it where that is not the name,
    ``title`` one sentence for the report; ``commands`` are its nouns on the command line (`cli.commands` says where
    their functions stand), ``planner`` that of ``plan``; ``uses`` are those of its tests.
    """

    name: str
    title: str
    kind_of_test: str = ""
    commands: Sequence[Command] = ()
    planner: Command | None = None
    planner_type: type[object] | None = None  # its settings, where options are enough for them
    command_module: str = ""
    plan_type: type[P]
    said_type: type[object] | None = None  # its noun's own settings on a file: a dataclass of settings
    shown_type: type[object] | None = None  # its noun's own settings on what is shown
    inputs: InputSpec
    influences: Mapping[str, str] = {}
    uses: frozenset[str] = frozenset({"fit", "report_only"})
    corrects: Literal["", "bias", "matrix"] = ""  # what it finds that later tests take off their readings
    set_against: bool = False  # two of its tests can be set beside each other: `against` says how
    changes: bool = False  # the figures of a test can be set against those of an earlier one, one by one
    chosen_by: str = "Choose by windows"  # how a test takes a part of a recording
    counts_dwells: bool = True
    figures: Sequence[FigureSpec] = ()
    compared: Compared | None = None
    gives: tuple[TermKind, ...] = ()  # kinds of terms (``model_terms.KINDS``) that its ``terms`` can hold
    judged_alone: bool = False  # each test held out by itself, on readings that nothing was taken off
    compensated: tuple[str, ...] = ()  # quantities that a requirement can ask of compensated readings held out
    takes_corrections: bool = False  # readings may have a bias taken off that another test found
    takes_matrix: bool = False  # and scale factors and misalignment
    made_of: str = ""  # procedure whose tests, named by ``after``, it is made of: they then give the model no terms
    no_corrections: str = ""  # why they may not

    @property
    def makes_model(self) -> bool:
        """Whether a model can be made of its tests alone; noise alone is none."""
        return any(kind != "noise" for kind in self.gives)

    # ---- from a file to what a campaign says of it -----------------------------------------------------------------

    def split_label(self, given: str) -> tuple[str, str]:
        """Return what a caller calls a file, and the file: ``"x+=up.csv"``; by default there are no such names."""
        return "", given

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return what a file is taken for, sensor by sensor: its channels, by names and units, by default.

        Raises
        ------
        UsageError
            If that is not clear.
        """
        from .given import described  # noqa: PLC0415

        return [described(given, self.inputs)]

    def like(self, given: GivenFile, entry: Mapping[str, Any]) -> tuple[dict[str, Any], Sequence[Remark]]:
        """Return the entry of a recording of another campaign as it holds for a file, and remarks on it.

        Raises
        ------
        UsageError
            If it does not hold for this file.
        """
        return dict(entry), ()

    # ---- from what was said to readings -----------------------------------------------------------------------

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return the fields of the plan that come from sensor, site and standards: by default those of its names."""
        from dataclasses import fields  # noqa: PLC0415

        named = fields(self.plan_type)  # type: ignore[arg-type]
        known = {"sensor", "site", "standards"}
        return {one.name: getattr(facts, one.name) for one in named if one.metadata.get("from") in known}

    def plan(self, values: Mapping[str, Any], facts: Facts) -> P:
        """Return the plan of a test, by the settings that were given and by the facts.

        Raises
        ------
        PlanError
            If they cannot be meant.
        """
        return self.plan_type(**{**values, **self.plan_fields(facts)})

    def inputs_for(self, plan: P, corrections: Sequence[Correction] = ()) -> InputSpec:
        """Return what is taken with this plan; before a correction, temperatures by the body axis of their sensor."""
        return replace(self.inputs, by_body=True) if corrections else self.inputs

    def readings(self, plan: P, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> R:
        """Return the readings of all sources of a test.

        Raises
        ------
        DataError
            If they cannot be read.
        """
        raise NotImplementedError

    def agreement(self, plan: P, readings: R) -> Sequence[Remark]:
        """Return where recordings, or parts of them, disagree with the nominal or with each other.

        Each remark has the severity ``"error"``, the file of its recording in ``where``, the name of the recording and
        the likely cause in ``what``. No model is made of a test with one.
        """
        return ()

    @property
    def agreement_many(self) -> Callable[[Sequence[tuple[P, R]]], Sequence[Sequence[Remark]]] | None:
        """What gives the same of each of many tests, of many units; None where each is looked at by itself."""
        return None

    def reduce(self, plan: P, readings: R) -> S:
        """Return the result: pure."""
        raise NotImplementedError

    def reduce_many(self, tests: Sequence[tuple[P, R]]) -> list[S | InertialcalError]:
        """Return the result of each of many tests, of many units, or why it is refused: the same as `reduce` gives.

        A form of its own shares what tests have in common (the design of one plan, the compiled loop over readings).
        What is not refused but breaks down (an ``ArithmeticError``) may end the whole call: the engine then reduces
        the tests one by one.
        """
        found: list[S | InertialcalError] = []
        for plan, readings in tests:
            try:
                found.append(self.reduce(plan, readings))
            except InertialcalError as error:
                found.append(error)
        return found

    def by_sensor(self, result: S) -> Mapping[str, S]:
        """Return the part of a result about each kind of sensor; the whole, without a name, where it holds one."""
        return {"": result}

    def remarks(self, facts: Facts) -> Sequence[Remark]:
        """Return what there is to say of the sensor alone."""
        return ()

    # ---- judged -----------------------------------------------------------------------------------------------

    def quantities(self) -> Mapping[str, Quantity]:
        """Return what there is to say of the figures that it can give, by quantity."""
        return {}

    def quantities_of(self, settings: Mapping[str, Any]) -> Mapping[str, Quantity]:
        """Return the same of further figures of a test with these settings, as of channels that they name.

        The settings are as a campaign file has them, and may be wrong.
        """
        return {}

    def exclusions(self, test: Tested[P, R, S]) -> Iterator[Exclusion]:
        """Yield what was not used; what the chain left out and what was not chosen is the engine's to tell."""
        yield from ()

    def needs(self, influence: str, result: S) -> bool:
        """Return whether an influence that is not stated would change this result."""
        return influence in self.influences

    def effects(self) -> Mapping[str, str]:
        """Return what each influence changes in this test."""
        return self.influences

    def judge(self, asked: Asked, tests: Sequence[Tested[P, R, S]]) -> tuple[list[Verdict], list[Row]] | None:
        """Return verdicts on a requirement that all these tests are about, and rows that follow from it.

        None leaves it to the general rule, which judges every row of that quantity by its interval.
        """
        return None

    def judge_compensated(
        self, asked: Asked, test: Tested[P, R, S], model: SensorModel
    ) -> list[tuple[Verdict, Verdict | None]]:
        """Return verdicts on readings held out once a model has compensated them, and the same as they were read.

        For the quantities in ``compensated`` alone. The model is a given function here: what is not known of it shows
        in the readings, and u is that of a test of its own.
        """
        return []

    def interval_at(self, result: S, row: Row, p: float) -> Interval | None:
        """Return the interval of another probability of a row that is a size; None where it has none."""
        return row.interval if row.interval is not None and row.interval.p == p else None

    def doubt(self, result: S, axis: str) -> str:
        """Return why figures of an axis may not hold; empty where nothing speaks against them."""
        return ""

    def called(self, result: S, key: Key) -> Key:
        """Return the key of a value of the estimate as rows have it."""
        return key

    def budgeted(self, result: S) -> Sequence[BudgetFigure]:
        """Return the figures whose budgets are worth a table: by default all values of the estimate."""
        found = result.estimate
        return [] if found is None else budget_figures(found, [self.called(result, key) for key in found.keys])

    # ---- set beside each other --------------------------------------------------------------------------------

    def correction(self, test: str, result: S) -> Correction | None:
        """Return what later tests may take off their readings; None where there is nothing."""
        return None

    def against(self, test: Tested[P, R, S], other: Tested[Any, Any, Any]) -> Sequence[Row] | None:
        """Return what two tests differ by; None where they are not set beside each other.

        Raises
        ------
        PlanError, DataError
            If the two cannot be.
        """
        return None

    def levels(self, result: S) -> Levels:
        """Return figures that are told only as changes from another test; with `changes`."""
        return Levels()

    # ---- the model of a sensor --------------------------------------------------------------------------------

    def joined(self, tests: Sequence[Tested[P, R, S]]) -> tuple[P, R] | None:
        """Return plan and readings of tests that give the same terms, to be reduced together.

        None where each has its own result: one test, or several that cannot be reduced together (two that give one
        term are then refused).

        Raises
        ------
        PlanError
            If they could be, but for their plans: ``plans_differ``.
        """
        return None

    def terms(self, result: S, tests: Sequence[Tested[P, R, S]]) -> ModelTerms | None:
        """Return the terms of the model that a (joint) result of tests gives; None where there are none."""
        return None

    def terms_many(self, given: Sequence[tuple[S, Sequence[Tested[P, R, S]]]]) -> list[ModelTerms | None]:
        """Return what `terms` gives of each of many results, of many units, with the tests behind each.

        What breaks down in one of them ends the whole call: the engine then asks for each by itself.
        """
        return [self.terms(result, tests) for result, tests in given]

    def without_model(self, plan: P) -> str:
        """Return what a test lacks whose figures are none of a model's; empty where each says why it is not there."""
        return ""

    def check_alike(self, tests: Sequence[Tested[P, R, S]]) -> None:
        """Refuse tests of one model, fitted or held out, whose terms mean different things.

        Raises
        ------
        PlanError
            ``plans_differ``.
        """

    def held_out(
        self, result: S, fitted: Sequence[Tested[P, R, S]], held: Sequence[Tested[P, R, S]], model: SensorModel | None
    ) -> HeldOut | None:
        """Return what readings held out say, without verdicts; None where they cannot be judged.

        Parameters
        ----------
        result
            (Joint) of the tests that were fitted.
        fitted, held : sequence of Tested
            Behind the model, and held out. Where no model is made of the procedure: one test each, of one condition.
        model : SensorModel or None
            Of the tests that were fitted, for readings after the same corrections.
        """
        return None

    # ---- shown ------------------------------------------------------------------------------------------------

    def rows(self, result: S) -> Sequence[Row]:
        """Return the rows of ``results.json``, SI, of a result about one sensor."""
        return result.rows()

    def rows_many(self, results: Sequence[S]) -> list[Sequence[Row]]:
        """Return what `rows` gives of each of many results, of many units; what breaks down in one ends the call."""
        return [self.rows(one) for one in results]

    def curves(self, result: S) -> Sequence[Curve]:
        """Return the curves of ``results.json``, SI."""
        made: Callable[[], Sequence[Curve]] | None = getattr(result, "curves", None)
        return () if made is None else made()

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return what a test found as one sentence, of its rows in ``results.json``: its error, or its bias."""
        return error_sentence(rows)

    def truths(self, result: S) -> Sequence[Row] | None:
        """Return rows that are held against the truth of a rig; None where the estimate says all."""
        return None

    # ---- what its noun prints and writes, beyond tables and figures ---------------------------------------------

    def report(self, found: Reduced) -> str | None:
        """Return what its command prints; None for the table of the figures."""
        return None

    def summary(self, found: Reduced) -> str:
        """Return one line on what was in the files, for the terminal; empty for none."""
        return ""

    def content(self, found: Reduced) -> Mapping[str, object]:
        """Return what its command adds to ``--json``."""
        return {}

    def files(self, found: Reduced) -> Mapping[str, str]:
        """Return what ``-o FOLDER`` writes besides all figures: texts by file name."""
        return {}

    def planned(self, given: Mapping[str, Any]) -> Planned:
        """Return what a test will give, by the settings of ``planner_type`` as text with units.

        Raises
        ------
        UsageError, PlanError
            If they cannot be meant.
        """
        raise NotImplementedError

    def rehearsed(self, given: Mapping[str, Any], schedule: Table, seed: int) -> Rehearsal:
        """Return what the schedule of a plan gives on a simulated unit, by the same settings.

        Raises
        ------
        UsageError, DataError
            If they cannot be meant, or the schedule cannot be read.
        """
        raise NotImplementedError

    # ---- files that nobody has said anything of ---------------------------------------------------------------------

    def suggests(self, recording: Recording, survey: Survey) -> Suggestion | None:
        """Return the command to type next for a file, where it looks made for this test."""
        return None

    def found_in(self, root: Path) -> tuple[dict[str, object], list[Remark]]:
        """Return recordings of a folder that are several files each, by name, and what there is to remark."""
        return {}, []

    def claims(self, file: FolderFile) -> Claim | None:
        """Return how much a file of a folder is made for this test."""
        return None

    def asks(self, contents: Mapping[str, object]) -> Sequence[Question]:
        """Return what it has to be told of what was made of claimed files, by file."""
        return ()

    def belong_together(self, contents: Sequence[object]) -> bool:
        """Return whether what was made of claimed files can be one test; else those in reserve have them."""
        return True

    def draft(self, contents: Mapping[str, object]) -> Draft:
        """Return what a first campaign.toml says of what was made of claimed files, by file."""
        raise NotImplementedError

    # ---- what a campaign says of it, before any recording is read ------------------------------------------------

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return its own keys of a recording's entry."""
        return ()

    def check(self, test: SaidTest) -> Iterator[Problem]:
        """Yield what is wrong with a test."""
        yield from ()

    def check_recording(self, test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
        """Yield what is wrong with a recording of a test."""
        yield from ()

    def check_entry(self, name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
        """Yield what is wrong with its keys of a recording's entry, whichever test reads it."""
        yield from ()
