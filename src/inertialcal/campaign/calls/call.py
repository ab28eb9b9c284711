"""A procedure on files, Recordings or arrays, by a command or from Python: a campaign of its own, never written.

What is given becomes a campaign document (`document`), which is validated and reduced as `run` does it: the same plan,
facts, sources, path and figures to the last bit.
"""

from __future__ import annotations

import inspect
import os
import shutil
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from pydantic import ValidationError

from ...core.batches import unchanged
from ...core.campaign_text import FILE, toml_text
from ...core.errors import DataError, InertialcalError, Problem, StoreError, UsageError
from ...core.interruption import interruption
from ...core.key import AXES
from ...core.remarks import Remark, gather
from ...core.results import Row
from ...core.schema.problems import model_problems
from ...core.schema.settings import settings_values
from ...core.settings import Setting, grouped_settings, settings_of
from ...core.show.frames import frame_of_rows
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.tables import Block, html, text
from ...files.time.stamps import time_remarks
from ...files.write.atomic import atomic_write, work_folder
from ...files.write.exchange import file_digest
from ...files.write.portable import portable_name
from ...procedures import procedure_of
from ...procedures.given import GROUP, GivenFile, Said
from ...procedures.protocol import Procedure, Tested
from ...signals.blas import one_blas_thread
from ..engine.engine import ReducedTest, computable
from ..engine.status import EXIT
from ..engine.whole import Whole, reduce_campaign
from ..file.cross_checks import cross_checks
from ..file.load import Campaign, standards_of
from ..file.recordings import OWN_KEYS
from ..file.schema import CampaignFile
from ..outcome.contents import displayed_rows
from .document import INNER_FILES, Document, document_of
from .given import Files, Given, files_of, given_items

if TYPE_CHECKING:
    from pandas import DataFrame

    from ...sensors.model.sensor_model import SensorModel


RETURNS = """
Returns
-------
Reduced
    Figures, remarks, and what was used.

Raises
------
UsageError
    If a setting is wrong, or it is not clear what a file holds.
DataError
    If a file cannot be read, or cannot carry the answer.
"""


@dataclass(frozen=True, eq=False)
class Reduced:
    """What a procedure found in the files that it was given.

    Parameters
    ----------
    procedure : str
        Its name.
    rows : tuple of Row
        The figures, in the unit of the sensor.
    inputs : mapping of str to str
        SHA-256 by path.
    columns : mapping of str to str
        Which column was taken for what, in the first file.
    remarks : tuple of Remark
        What reading and reducing brought up.
    whole : Whole
        Tests with plan, readings and result (SI), model, content of ``results.json``.
    document : dict
        The campaign that the call stands for.
    files : Files
        What was given.
    shown : object
        Settings of what is shown (``Procedure.shown_type``).
    word : str
        The command.
    """

    procedure: str
    rows: tuple[Row, ...]
    inputs: Mapping[str, str]
    columns: Mapping[str, str]
    remarks: tuple[Remark, ...]
    whole: Whole
    document: Document
    files: Files
    shown: Any = None
    word: str = ""

    @property
    def tested(self) -> list[Tested[Any, Any, Any]]:
        """Plan, readings and result of each test, SI."""
        return [one.tested for one in self.whole.tested]

    @property
    def tests(self) -> list[ReducedTest]:
        """The test of the files, and that of the files held out."""
        return self.whole.tested

    @property
    def result(self) -> Any:
        """Of the procedure, SI."""
        return self.tests[0].result

    @property
    def plan(self) -> Any:
        """Of the procedure."""
        return self.tests[0].tested.plan

    @property
    def unit(self) -> str:
        """Of the sensor's readings."""
        return self.tests[0].tested.facts.unit

    @property
    def models(self) -> dict[str, SensorModel]:
        """Models by kind of sensor, of those that the readings could carry and that readings held out do not refute."""
        made = () if self.whole.modelled is None else self.whole.modelled.delivered
        return {one.model.kind: one.model for one in made if one.model is not None}

    @property
    def errors(self) -> tuple[Remark, ...]:
        """Why the figures may not hold: no model is made of them."""
        return tuple(dict.fromkeys(one for each in self.tests for one in each.errors))

    @property
    def verdicts(self) -> Sequence[Mapping[str, Any]]:
        """On what was asked of the figures, as ``results.json`` has them; none where nothing was."""
        asked = bool(self.document.get("requirements"))
        return self.results["verdicts"] if asked else ()

    @property
    def exit_status(self) -> int:
        """0, or 4 where the figures may not hold; by the verdict where something was asked of them."""
        if self.document.get("requirements"):
            return EXIT[self.whole.verdict]
        return EXIT["INCONCLUSIVE"] if self.errors else 0

    @property
    def first_figure(self) -> str:
        """Name of the figure that the command draws; empty where it is the first that there are data for."""
        return next((one.figure for one in procedure_of(self.procedure).commands if one.word == self.word), "")

    @cached_property
    def results(self) -> dict[str, Any]:
        """Content of ``results.json``."""
        return self.whole.results

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: which column is what, the figures, how many remarks."""
        procedure = procedure_of(self.procedure)
        taken = ", ".join(f"{what} = {name}" for what, name in self.columns.items())
        rows = [row.to_dict() for row in self.rows if not row.case.beside]
        count = len(self.inputs)
        caption = f"{procedure.kind_of_test or self.procedure.replace('_', ' ')}: {count} file{'s'[: count != 1]}"
        head = [f"columns: {taken}", *([summary] if (summary := procedure.summary(self)) else [])]
        opened = [one.what for each in self.tests for one in each.opened]
        if self.document.get("requirements"):
            opened.append(f"verdict: {self.whole.verdict}")
        return (*head, *estimate_table(rows, caption), *opened, *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook, with the first figure."""
        from ...report.plot import markup  # noqa: PLC0415 - draws, which starts slowly

        return html(self.parts(), markup(self))

    def write_models(self, path: str | Path) -> list[Path]:
        """Write the models; of several, each has its sensor in the name: ``model_acc.json``, ``model_gyro.json``.

        Raises
        ------
        DataError
            ``no_model`` where there is none; the code of each error for which there is none; ``overwrites_input``.
        StoreError
            ``not_written``.
        """
        from ...files.models.model_json import dump_model  # noqa: PLC0415

        target, models = Path(path), self._models(str(path))
        written = []
        for name, model in models.items():
            written.append(target.with_stem(f"{target.stem}_{name}") if len(models) > 1 else target)
            with atomic_write(written[-1], list(self.inputs)) as aside:
                aside.write_text(dump_model(model), encoding="utf-8", newline="\n")
        return written

    def exported(self, to: str) -> tuple[str, tuple[Remark, ...]]:
        """Return the models in a format for others, judged or not, and what it cannot hold.

        Raises
        ------
        UsageError
            ``unsupported_format``; ``one_sensor`` where the format holds one, and the readings gave two.
        DataError
            ``no_model`` where there is none; as ``files.models.model_file.content``.
        """
        from ...files.models.model_file import ModelFile, content  # noqa: PLC0415
        from ...files.models.model_json import dump_model  # noqa: PLC0415
        from ...sensors.model.model_set import ModelSet  # noqa: PLC0415

        models = self._models(to)
        sources = [
            ModelFile(next(iter(self.inputs), ""), dump_model(one).encode(), ModelSet((one,)))
            for one in models.values()
        ]
        data, remarks = content(sources, to, unjudged=True)
        return data.decode(), remarks

    def _models(self, target: str) -> dict[str, SensorModel]:
        """Return the models by the word of their sensor.

        Raises
        ------
        DataError
            ``no_model`` where there is none; the code of each error for which there is none.
        """
        models = {GROUP[kind]: model for kind, model in self.models.items()}
        if not models and self.errors:
            why = "no model is made of recordings that disagree"
            raise DataError([replace(one.problem, why=why) for one in self.errors])
        if not models:
            do = procedure_of(self.procedure).without_model(self.plan)
            do = do or "Look at the result alone: it says why each figure was not estimated"
            raise DataError("no figure that a model takes was estimated", target, do=do, code="no_model")
        return models

    def write_campaign(self, folder: str | Path) -> Path:
        """Write what was used as a campaign: its file, and copies of the recordings.

        Returns
        -------
        Path
            Of campaign.toml: ``run`` on its folder gives the same figures.

        Raises
        ------
        StoreError
            If the folder holds a campaign, or cannot be written.
        """
        return write_campaign(self.document, self.files, Path(folder))


@one_blas_thread()
def call(
    name: str,
    given: Given | Sequence[Given],
    settings: Mapping[str, Any],
    *,
    held_out: Sequence[str | Path] = (),
    options: bool = False,
    word: str = "",
) -> Reduced:
    """Return what a procedure finds in files, Recordings or arrays.

    Parameters
    ----------
    name : str
        Of the procedure.
    given : path, Recording, array of shape (n,) or (n, 3), or several
        What it is made of.
    settings : mapping of str to object
        What was said: of the recordings and their sensor (`procedures.given.Said`), the procedure's own of a file, its
        plan, and of what is shown. Quantities are text with a unit.
    held_out : sequence of path
        Files that the model is judged on.
    options : bool
        Messages speak of options, not of arguments.
    word : str
        The command, where the procedure has several.

    Raises
    ------
    UsageError
        If a setting is wrong, or it is not clear what a file holds.
    DataError
        If a file cannot be read, or cannot carry the answer.
    """
    procedure = procedure_of(name)
    parts = split_settings(procedure, settings)
    said = _made(Said, parts["said"])
    items = given_items(given)
    labelled = [procedure.split_label(str(one)) if isinstance(one, str | Path) else ("", one) for one in items]
    names, files = files_of([one for _, one in labelled], said, procedure.inputs)
    labels = dict(zip(names, (label for label, _ in labelled), strict=True))
    held = [str(one) for one in held_out]
    given_files: list[GivenFile] = []
    for number, one in enumerate([*names, *held], 1):
        own = partial(files.read, one), partial(files.table, one)
        given_files.append(
            GivenFile(one, said, parts["own"], parts["plan"], *own, has_rows=one not in files.held,
                      options=options, number=number, together=given_files, label=labels.get(one, ""))
        )  # fmt: skip
    plan, _ = _settings(procedure.plan_type, parts["plan"], options)
    if procedure.said_type is not None:
        _settings(procedure.said_type, parts["own"], options)
    shown = None
    if procedure.shown_type is not None:
        shown = procedure.shown_type(**_settings(procedure.shown_type, parts["shown"], options)[1])
    try:
        with unchanged(channel.data for one in files.held.values() for channel in one.channels):
            document, columns, described = document_of(procedure, given_files, plan, held)
            campaign, whole, refused = _reduced(document, files)
    except InertialcalError as error:
        read = [(one, files.held[one].source.sha256) for one in names if one in files.held]
        error.inputs = error.inputs or tuple(read)
        raise
    with computable(campaign.file.campaign.id, "campaign"):
        mine = [
            one for one in whole.tested if one.test.procedure == procedure.name
        ]  # of its parts, their results have them
        rows = tuple(displayed_rows(campaign, mine))
    timed = [remark for one in files.held.values() for remark in time_remarks(one)]
    judged = [] if whole.modelled is None else [remark for one in whole.modelled.every for remark in one.remarks]
    several = len(whole.tested) > 1 and not held
    tested = [one.at(each.test.id) if several else one for each in whole.tested for one in each.remarks]
    remarks = gather([*described, *tested, *refused, *judged, *timed])
    word = word or procedure.commands[0].word
    return Reduced(procedure.name, rows, whole.inputs, columns, remarks, whole, document, files, shown, word)


def _reduced(document: Document, files: Files) -> tuple[Campaign, Whole, list[Remark]]:
    """Reduce a document; where one sensor of several cannot be, leave its test out of it and say why.

    Raises
    ------
    UsageError, DataError
        If nothing can be reduced.
    """
    campaign = campaign_of(document)
    try:
        return campaign, reduce_campaign(campaign, files), []
    except DataError as error:
        tests = document["tests"]
        if len(tests) < 2 or any(one.get("use") != "fit" for one in tests):
            raise
        possible: list[dict[str, Any]] = []
        problems: list[Problem] = []
        for one in tests:
            try:
                reduce_campaign(campaign_of({**document, "tests": [one]}), files)
            except DataError as own:
                problems += own.problems
            else:
                possible.append(one)
        if not possible or not problems:
            raise error from None
    document["tests"] = possible
    campaign = campaign_of(document)
    refused = [Remark("no_result", "error", one.what, one.where, do=one.do) for one in problems]
    return campaign, reduce_campaign(campaign, files), refused


def settings_by_group(procedure: Procedure[Any, Any, Any]) -> dict[str, tuple[Setting, ...]]:
    """Return the settings of a noun by what they are of: the recordings, the file, the plan, what is shown."""
    own = {"plan": procedure.plan_type, "own": procedure.said_type, "said": Said, "shown": procedure.shown_type}
    return grouped_settings(own)


def split_settings(procedure: Procedure[Any, Any, Any], given: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the settings that were given, by group.

    Raises
    ------
    UsageError
        If there is no such setting.
    """
    groups = settings_by_group(procedure)
    found: dict[str, dict[str, Any]] = {group: {} for group in groups}
    home = {one.name: group for group, kind in groups.items() for one in kind}
    every = {one.name: one for kind in groups.values() for one in kind}
    for name, value in given.items():
        if name not in home:
            raise UsageError(f"no setting {name!r}", do=f"There are: {', '.join(home)}", code="unknown_name")
        if value is not None:
            one = every[name]
            found[home[name]][name] = _named_values(value) if one.pairs else value
    return found


def _named_values(value: Any) -> Mapping[str, str]:
    """Return values by name; what has none stands under itself."""
    if isinstance(value, Mapping):
        return value
    return {one: one for one in ([value] if isinstance(value, str) else value)}


def _made(kind: type[Any], given: Mapping[str, Any]) -> Any:
    """Return settings as their dataclass."""
    known = {one.name for one in fields(kind)}
    return kind(**{name: value for name, value in given.items() if name in known})


def _settings(kind: type[Any], given: Mapping[str, Any], options: bool) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return settings as a campaign has them, and their values, SI; what is wrong is in the words of the caller.

    Raises
    ------
    UsageError
        If a setting cannot be meant.
    """
    known = {one.name: one for one in settings_of(kind)}
    plan = {name: _as_said(known[name], value, options) for name, value in given.items()}

    def called(path: tuple[str | int, ...]) -> str:
        first, *inner = (str(part) for part in path if isinstance(part, str))
        return ".".join([f"--{known[first].option}" if options and first in known else first, *inner])

    values, problems = settings_values(kind, plan, lambda *_: "", called=called)
    if problems:
        raise UsageError(problems)
    return plan, values


def _as_said(one: Setting, value: Any, options: bool) -> Any:
    """Return a setting as a campaign has it: lists for sequences, inline tables from their text, numbers with units."""
    if one.table is not None and isinstance(value, str):
        try:
            return tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            name = f"--{one.option}" if options else one.name
            do = f"Write it like {one.example}"
            raise UsageError(f"{name}: {value!r} is not a TOML table", do=do, code="wrong_value") from None
    if one.many:
        return [value] if isinstance(value, str | int | float) else list(value)
    if one.choices and isinstance(value, str):  # a choice of numbers, typed as an option
        return {str(choice): choice for choice in get_args(one.kind)}.get(value, value)
    if one.pairs and float in get_args(next((k for k in get_args(one.kind) if get_args(k)), one.kind)):
        return _numbers(one, value, options)
    return value


def _numbers(one: Setting, given: Mapping[str, Any], options: bool) -> dict[str, float]:
    """Return a number an axis; one without a name is that of all."""
    found: dict[str, float] = {}
    for name, value in given.items():
        try:
            found |= dict.fromkeys(AXES if name == value else (name,), float(value))
        except ValueError:
            what = f"{f'--{one.option}' if options else one.name}: {value!r} is not a number"
            raise UsageError(what, do="Write it like x=32768", code="wrong_value") from None
    return found


def campaign_of(document: Document, checked: bool = True) -> Campaign:
    """Return a document as a campaign; unchecked, what one key says of another is not looked at.

    Raises
    ------
    UsageError
        With every problem.
    """
    try:
        file = CampaignFile.model_validate(document)
    except ValidationError as error:
        raise UsageError(list(model_problems(error, CampaignFile, document, lambda *_: ""))) from None
    standards, problems = standards_of(file, lambda *key: "")
    problems += cross_checks(None, file, lambda *key: "") if checked else []
    if problems:
        raise UsageError(problems)
    return Campaign(Path(), file, standards, None, "")


def write_campaign(document: Document, files: Files, folder: Path) -> Path:
    """Write a document with copies of its recordings as a campaign folder; return the path of its file.

    Raises
    ------
    StoreError
        If there is a campaign, or the folder cannot be written.
    """
    from ...files.write.recording import write  # noqa: PLC0415

    path = folder / FILE
    if path.exists():
        raise StoreError(f"{path} exists", do="Name another folder", code="exists")
    sensors = {name: dict(sensor) for name, sensor in document["sensors"].items()}
    placed: dict[str, str] = {}

    def place(source: str) -> str:
        if source not in placed:
            placed[source] = _placed(source, files, folder, set(placed.values()), write)
        return placed[source]

    interruption.note(folder, complete=False)
    try:
        (folder / "recordings").mkdir(parents=True, exist_ok=True)
        recordings = {name: _with_files(entry, place) for name, entry in document["recordings"].items()}
        for sensor in sensors.values():
            chain = sensor.get("chain", {})
            if "model" in chain:
                sensor["chain"] = {**chain, "model": place(chain["model"])}
        with atomic_write(path, new=True) as aside:
            aside.write_text(
                toml_text({**document, "sensors": sensors, "recordings": recordings}), encoding="utf-8", newline="\n"
            )
        interruption.note(folder)
    except OSError as error:
        raise StoreError(f"cannot write {folder}: {error.strerror}", code="not_writable") from None
    return path


def _with_files(entry: Mapping[str, Any], place: Callable[[str], str]) -> dict[str, Any]:
    """Return the entry of a recording with its files, and those that say more of it, where they are copied to."""
    found = dict(entry)
    for key, value in entry.items():
        if isinstance(value, Mapping):
            found[key] = {**value, **{k: place(value[k]) for k in INNER_FILES if isinstance(value.get(k), str)}}
        elif isinstance(value, str) and (key == "file" or (key in OWN_KEYS and Path(value).is_file())):
            found[key] = place(value)
    return found


def _placed(source: str, files: Files, folder: Path, taken: set[str], write: Callable[..., Any]) -> str:
    """Copy a file into a campaign folder, or write a recording there; return its path inside. What is inside stays."""
    origin = Path(source)
    if origin.exists() and origin.resolve().is_relative_to(folder.resolve()):
        return origin.resolve().relative_to(folder.resolve()).as_posix()
    stem = portable_name(origin.name if origin.exists() else f"{origin.name}.parquet")
    cased = {one.casefold() for one in taken}  # one file, on Windows and macOS
    name, count = f"recordings/{stem}", 2
    digest = file_digest(origin, follow=True)  # "" of a folder, or of a recording in memory
    while name.casefold() in cased or os.path.lexists(folder / name):
        if name.casefold() not in cased and digest and digest == file_digest(folder / name):
            return name
        name, count = f"recordings/{count}_{stem}", count + 1
    if origin.is_dir():
        with work_folder(folder / "recordings") as work:
            shutil.copytree(origin, work / "copy").rename(folder / name)
    elif origin.exists():
        with atomic_write(folder / name, new=True) as aside:
            shutil.copyfile(origin, aside)
    else:
        write(files.held[source], folder / name)
    return name


def function_of(name: str, word: str = "") -> Callable[..., Reduced]:
    """Return a command of a procedure as a function: its settings are its arguments and its documentation."""
    procedure = procedure_of(name)
    word = word or procedure.commands[0].word
    declared = next(one for one in procedure.commands if one.word == word)
    groups = settings_by_group(procedure)

    def function(
        recordings: Given | Sequence[Given], /, *, hold_out: Sequence[str | Path] = (), **given: Any
    ) -> Reduced:
        return call(name, recordings, given, held_out=hold_out, word=word)

    keyword = inspect.Parameter.KEYWORD_ONLY
    first = inspect.Parameter("recordings", inspect.Parameter.POSITIONAL_ONLY)
    every = [one for group in groups.values() for one in group]
    named = [inspect.Parameter(one.name, keyword, default=None) for one in every]
    if "hold_out" in procedure.uses:
        named.append(inspect.Parameter("hold_out", keyword, default=()))
    function.__signature__ = inspect.Signature([first, *named])  # type: ignore[attr-defined]
    function.__name__ = function.__qualname__ = declared.function
    function.__module__ = "inertialcal"
    function.__doc__ = documentation(procedure)
    return function


def documentation(procedure: Procedure[Any, Any, Any]) -> str:
    """Return the documentation of a noun's function, made of its settings."""
    lines = [procedure.title, "", "Parameters", "----------", "recordings : path, Recording, array, or several",
             "    Files in any format that ``inertialcal.read`` takes."]  # fmt: skip
    for group in settings_by_group(procedure).values():
        for one in group:
            lines += [f"{one.name} : {one.type_text}", f"    {one.described}"]
    if "hold_out" in procedure.uses:
        lines += ["hold_out : sequence of path, optional", "    Files that the model is judged on."]
    return "\n".join([*lines, RETURNS])


__all__ = ["Reduced", "call", "campaign_of", "documentation", "function_of", "write_campaign"]
