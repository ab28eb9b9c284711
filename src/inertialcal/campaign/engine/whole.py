"""The whole of a campaign: every test reduced, models made, requirements judged, the files of ``out/``."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple

from ...core.errors import DataError, InertialcalError, Problem
from ...core.remarks import Remark, gather
from ...core.results import COLUMNS, flat
from ...core.schema.json_text import json_text
from ...core.show.result_tables import remarks_line
from ...core.show.tables import Block, Table, html, text
from ...files.binary.curves import FILE as CURVES
from ...files.binary.curves import curves_bytes
from ...files.source import checked_path
from ...signals.blas import one_blas_thread
from ..compare.before_after import beside_others
from ..file.load import Campaign, load
from ..inputs.changed import check_unchanged, one_digest, stamps
from ..inputs.gate import Gate
from ..inputs.sources import ReadOnce, Store
from ..models.build import build_models, model_files
from ..models.judged import NOT_RUN, Modelled, Residual, hold_out_residuals
from ..outcome.contents import Figures, figures_and_verdicts, results_content
from ..outcome.publish import changes, check_writable, csv_text, provenance, publish, restore
from ..outcome.requirements import worst
from ..outcome.results_file import previous, sealed
from .cache import Cache
from .engine import (
    Prepared,
    ReducedTest,
    computable,
    placed,
    prepare,
    reduced_tests,
    shared_readings,
    with_opened,
)
from .reductions import Reduced, reduce_all, waiting_for
from .status import EXIT, Progress
from .together import Work, alone

VERDICT_COLUMNS = (
    "requirement", "test", "axis", "sensor", "at", "at_unit", "of", "value", "u", "unit", "lo", "hi", "p", "lower",
    "upper", "margin", "verdict", "reason",
)  # fmt: skip


class Checked(NamedTuple):
    """A campaign whose inputs were judged.

    Parameters
    ----------
    campaign : Campaign
        As read.
    inputs : dict of str to str
        SHA-256 of each input by its path.
    remarks : tuple of Remark
        What reading the inputs brought up.
    """

    campaign: Campaign
    inputs: dict[str, str]
    remarks: tuple[Remark, ...]

    @property
    def exit_status(self) -> int:
        """0, or 4 where a remark is an error."""
        return EXIT["INCONCLUSIVE"] if any(one.severity == "error" for one in self.remarks) else 0

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: the inputs that can be read, how many remarks."""
        file = self.campaign.file
        caption = f"campaign {file.campaign.id}: {len(file.tests)} test(s), every input can be read"
        return (Table(("input", "SHA-256"), list(self.inputs.items()), caption, (1,)), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    def __repr__(self) -> str:
        return text(self.parts())

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


@one_blas_thread()
def check(folder: str | Path) -> Checked:
    """Judge the inputs of a campaign without reducing them.

    Returns
    -------
    Checked
        A tuple of the campaign, the SHA-256 of each input by its path, and what reading the inputs brought up.

    Raises
    ------
    PlanError, DataError
        With every problem of the campaign file, or of the recordings.
    """
    checked_path(folder, "campaign")
    campaign = load(folder)
    inputs = {"campaign.toml": campaign.sha256}
    remarks: list[Remark] = []
    problems: list[Problem] = []
    ready: list[Prepared] = []
    gate = Gate()
    for number in range(len(campaign.file.tests)):
        try:
            prepared = prepare(campaign, number, gate=gate)
        except InertialcalError as error:
            problems += error.problems
            continue
        ready.append(prepared)
        inputs = one_digest([*inputs.items(), *prepared.inputs.items()])
        remarks += prepared.readings.remarks
    problems += [placed(one, campaign, number) for number, one in shared_readings(campaign, ready)]
    if problems:
        raise DataError(list(dict.fromkeys(problems)))
    return Checked(campaign, inputs, gather(remarks))


@one_blas_thread()
def work(
    campaign: Campaign, given: str, progress: Progress | None, write: bool, cache: Cache, paper: str = ""
) -> tuple[Whole, dict[str, Any], dict[str, str | bytes], list[str], tuple[Remark, ...]]:
    """Return a campaign reduced and judged: results, files of ``out/``, what changed since the last run, notes.

    Parameters
    ----------
    campaign : Campaign
        As read.
    given : str
        Its folder, as the user gave it.
    progress, write
        As ``run`` takes them.
    cache : Cache
        Where reductions and figures are kept.
    paper : str
        One of ``run.PAPER``: whether the report is written as PDF too, and with appendices.

    Raises
    ------
    PlanError, DataError, StoreError
        As ``run`` says.
    """
    notes: tuple[Remark, ...] = ()
    if write:
        check_writable(campaign.folder)
        notes = restore(campaign.folder)
    if paper:
        from ...report.paper import check_typst  # noqa: PLC0415 - draws, which starts slowly

        check_typst()
    before = stamps(campaign)
    whole = reduce_campaign(campaign, None, progress, cache)
    curves = curves_bytes(whole.results["curves"])
    results = sealed(whole.results, curves)
    files = _files(campaign, results, curves, whole.modelled, whole.inputs, given, cache, paper) if write else {}
    check_unchanged(campaign.folder, whole.inputs, before)
    changed = changes(previous(campaign.folder), results)
    if write:
        notes += publish(campaign.folder, files)
    return whole, results, files, changed, notes


@dataclass(frozen=True, eq=False)
class Whole:
    """A campaign that was reduced and judged.

    Parameters
    ----------
    campaign : Campaign
        As read.
    prepared : list of Prepared
        Its tests, as they were ready to be reduced.
    tested : list of ReducedTest
        Its tests.
    modelled : Modelled or None
        Model of each sensor and condition, and closed loop.
    inputs : dict of str to str
        As `Outcome` has them.
    """

    campaign: Campaign
    prepared: list[Prepared]
    tested: list[ReducedTest]
    modelled: Modelled | None
    inputs: dict[str, str]

    @cached_property
    def remarks(self) -> list[Remark]:
        """Of all tests, and of the closed loop."""
        every = () if self.modelled is None else self.modelled.every
        closed = [remark.at("closed loop") for one in every for remark in one.remarks]
        return [remark.at(one.test.id) for one in self.tested for remark in one.remarks] + closed

    @cached_property
    @one_blas_thread()
    def figures(self) -> Figures:
        """Its rows and verdicts, without budgets, curves and advice.

        Raises
        ------
        DataError
            ``not_computable``.
        """
        with computable(self.campaign.file.campaign.id, "campaign"):
            return figures_and_verdicts(self.campaign, self.tested, self.modelled)

    @cached_property
    @one_blas_thread()
    def results(self) -> dict[str, Any]:
        """As `Outcome` has them: made when they are first asked for, as a call may show its figures alone.

        Raises
        ------
        DataError
            ``not_computable``.
        """
        figures = self.figures
        with computable(self.campaign.file.campaign.id, "campaign"):
            found = results_content(self.campaign, self.prepared, self.tested, self.modelled, self.remarks, figures)
        return found | {"verdict": self.verdict or None}

    @cached_property
    def verdict(self) -> str:
        """As `Outcome` has it.

        Raises
        ------
        DataError
            ``not_computable``.
        """
        stated = [worst([one for one, _ in self.figures.judged])] if self.campaign.file.requirements else []
        if self.modelled is not None and self.modelled.whole_verdict != NOT_RUN:
            stated.append(self.modelled.whole_verdict)
        stated += ["INCONCLUSIVE"] * any(one.errors for one in self.tested)
        return next((word for word in ("FAIL", "INCONCLUSIVE", "PASS") if word in stated), "")


@one_blas_thread()
def reduce_campaign(
    campaign: Campaign, store: Store | None = None, progress: Progress | None = None, cache: Cache | None = None
) -> Whole:
    """Reduce every test of a campaign and judge its requirements.

    Parameters
    ----------
    campaign : Campaign
        Read from a folder, or made of what a noun was given.
    store : Store, optional
        That holds its files; by default its folder.
    progress : callable, optional
        As `run` takes it.
    cache : Cache, optional
        Where reductions are kept.

    Raises
    ------
    PlanError, DataError
        If the campaign or a recording is refused.
    """
    tell = progress or (lambda done, total, what: None)
    prepared, tested = reduce_tests(campaign, store, tell, cache)
    tell(len(tested), len(tested), "model and requirements")
    return alone(whole_of(campaign, prepared, tested))


def whole_of(campaign: Campaign, prepared: list[Prepared], tested: list[ReducedTest]) -> Work[Whole]:
    """Work out a campaign whose tests were reduced, with its models and what readings held out say of them.

    Raises
    ------
    DataError
        ``not_computable``; as the models say.
    """
    own = {"campaign.toml": campaign.sha256} if campaign.sha256 else {}
    inputs = own | one_digest(pair for one in prepared for pair in one.inputs.items())
    reduced = {one.test.id: one.tested for one in tested}
    with computable(campaign.file.campaign.id, "campaign"):
        errors = {one.test.id: one.errors for one in tested if one.errors}
        residuals = {
            name: one
            for name, one in hold_out_residuals(campaign, reduced).items()
            if not errors.keys() & {name, one.against}
        }
    tested = [_with_residuals(one, residuals.get(one.test.id)) for one in tested]
    with computable(campaign.file.campaign.id, "campaign"):
        modelled = yield from build_models(campaign, reduced, residuals, errors)
    return Whole(campaign, prepared, tested, modelled, inputs)


def reduce_tests(
    campaign: Campaign,
    store: Store | None = None,
    tell: Progress = lambda done, total, what: None,
    cache: Cache | None = None,
) -> tuple[list[Prepared], list[ReducedTest]]:
    """Reduce every test of a campaign: what was read, what was found.

    Raises
    ------
    DataError
        With all that was refused, test by test.
    """
    store = store or ReadOnce(campaign.folder, waiting_for(campaign))
    return alone(tests_of(campaign, *reduce_all(campaign, store, tell, cache)))


def tests_of(
    campaign: Campaign, found: dict[int, Reduced], problems: dict[int, tuple[Problem, ...]]
) -> Work[tuple[list[Prepared], list[ReducedTest]]]:
    """Work out the tests of a campaign set beside each other, as `reduce_tests`, of what `reduce_all` gives.

    Raises
    ------
    DataError
        With all that was refused, test by test.
    """
    tests = campaign.file.tests
    ready = {number: found[number].prepared for number in sorted(found)}
    for number, problem in shared_readings(campaign, list(ready.values())):
        problems[number] = (*problems.get(number, ()), placed(problem, campaign, number))
    if problems:
        raise DataError(list(dict.fromkeys(problem for number in sorted(problems) for problem in problems[number])))
    prepared = list(ready.values())
    results = {one.id: found[number].result for number, one in enumerate(tests)}
    tested = beside_others(campaign, (yield from reduced_tests(prepared, results)))
    for number, one in enumerate(tested):
        opened = found[number].opened
        tested[number] = one if opened is None else with_opened(campaign, one, opened)
    return prepared, tested


def _with_residuals(one: ReducedTest, residual: Residual | None) -> ReducedTest:
    """Return a test held out with the rows and curves of what is left on its readings."""
    if residual is None:
        return one
    return replace(one, rows=[*one.rows, *residual.found.rows], curves=residual.found.curves)


def _files(
    campaign: Campaign,
    results: dict[str, Any],
    curves: bytes,
    modelled: Modelled | None,
    inputs: dict[str, str],
    folder: str,
    cache: Cache,
    paper: str,
) -> dict[str, str | bytes]:
    from ...report.page import report_html  # noqa: PLC0415 - draws, which starts slowly; a call writes no report
    from .pictures import drawn  # noqa: PLC0415 - the same

    said = {"campaign": campaign.file.campaign.id, "of_campaign": campaign.digest()}
    record = provenance(inputs, folder, {}) | said
    model: dict[str, str | bytes] = {} if modelled is None else dict(model_files(modelled))
    content = json.loads(model["model.json"]) if "model.json" in model else None
    if paper:
        from ...report.paper import date_of, report_pdf  # noqa: PLC0415 - draws, which starts slowly

        draw = partial(drawn, cache=cache)
        pdf = report_pdf(results, content, record, draw, "appendices" in paper, date_of(os.environ))
        model["report.pdf"] = pdf
    return model | {
        "results.json": json_text({name: part for name, part in results.items() if name != "curves"}),
        CURVES: curves,
        "results.csv": csv_text([flat(row) for row in results["results"]], COLUMNS),
        "verdicts.csv": csv_text([row | (row["interval"] or {}) for row in results["verdicts"]], VERDICT_COLUMNS),
        "report.html": report_html(results, content, record, partial(drawn, cache=cache)),
        "provenance.json": json_text(record),
    }


__all__ = ["Checked", "Whole", "check", "reduce_campaign", "reduce_tests", "work"]
