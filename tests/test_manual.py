"""The manual is true: sessions print what the pages show, and every key, setting and option stands on its page.

A page's fenced blocks are played in order in an empty folder: ``console`` (commands after ``$``, then what they
print), ``python`` (must run), ``pycon`` (a doctest), ``code-block`` with a caption (a file of that name). A line
``...`` in an output stands for lines that are left out.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import json
import os
import re
import shlex
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import pytest
from pydantic_core import PydanticUndefined
from typer.main import get_command

import inertialcal as ic
from inertialcal.campaign.engine.whole import VERDICT_COLUMNS
from inertialcal.campaign.file import certificate as schema_certificate
from inertialcal.campaign.file import decisions as schema_decisions
from inertialcal.campaign.file import recordings as schema_recordings
from inertialcal.campaign.file import schema
from inertialcal.campaign.file import sensors as schema_sensors
from inertialcal.campaign.file.example import build
from inertialcal.cli.__main__ import main
from inertialcal.cli.app import app
from inertialcal.core.remarks import Remark
from inertialcal.core.results import COLUMNS
from inertialcal.core.schema import quantities as schema_words
from inertialcal.core.schema import standards as schema_standards
from inertialcal.core.settings import settings_of, settings_table
from inertialcal.core.show.rows import case_name
from inertialcal.files.binary.curves import read_curves
from inertialcal.procedures import procedure_names, procedure_of
from inertialcal.procedures.flip import entry as flip
from inertialcal.procedures.heads import entry as heads
from inertialcal.procedures.magnetometer_bias import entry as magnetometer_bias
from inertialcal.procedures.mass_attraction import entry as mass_attraction
from inertialcal.procedures.mass_attraction.planning.settings import Settings
from inertialcal.procedures.positions import entry as positions
from inertialcal.procedures.rate_table import entry as rate_table
from inertialcal.procedures.sensitivity import entry as sensitivity
from inertialcal.procedures.shifted_model import entry as shifted_model
from inertialcal.procedures.sine import entry as sine
from inertialcal.procedures.turned_mass import entry as turned_mass

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
SOURCE = ROOT / "src" / "inertialcal"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
TUTORIALS = ("gyro_suite", "microgravity_head", "hand_held_imu", "moved_mass")
FENCE = re.compile(r"^```(?P<kind>\{?[\w-]+\}?)[^\n]*\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL)
ELLIPSIS = "..."
REFUSED = (2, 3)
TYPED: Any = get_command(app)
COMMANDS: dict[str, Any] = {word: TYPED.get_command(None, word) for word in TYPED.list_commands(None)}
CAMPAIGN_TABLES: dict[str, type[schema_words.Strict]] = {
    "Top level": schema.CampaignFile,
    "`[campaign]`": schema.CampaignHead,
    "`[item]`": schema.Item,
    "`[site]`": schema.Site,
    "`[conditions.NAME]`": schema.Condition,
    "Each is a table with one of": schema_standards.StandardEntry,
    "`[sensors.NAME]`": schema_sensors.Sensor,
    "`chain`, the": schema_sensors.Chain,
    "`thermometer`:": schema_sensors.Thermometer,
    "`ground`, of": schema_sensors.Ground,
    "`gains.GAIN`, of": schema_sensors.AtGain,
    "`[recordings.NAME]`": schema_recordings.RecordingEntry,
    "`rows`, of": rate_table.Rows,
    "`means`, of": flip.Means,
    "`positions`, of": flip.Position,
    "`dwells`, of": flip.Dwells,
    "`rests`, of": positions.Rests,
    "`channels`, of": schema_recordings.ChannelEntry,
    "`conditions`, of": sensitivity.Condition,
    "`clock`, of": schema_recordings.Clock,
    "`text`, of": schema_recordings.TextLayout,
    "`schedule`, of": rate_table.Schedule,
    "`lines`, of": mass_attraction.Lines,
    "`mass`, of": mass_attraction.MovedMass,
    "`turned`, of": turned_mass.Turned,
    "`flips`, of": shifted_model.Flips,
    "`tle`, of": magnetometer_bias.Tle,
    "`head`, of": heads.Head,
    "`drive`, of": sine.KnownDrive,
    "`[[tests]]`": schema.Test,
    "`[decision]`": schema_decisions.Decision,
    "`process`, normal": schema_decisions.ProcessEntry,
    "`[model]`": schema.Model,
    "`[[requirements]]`": schema.Requirement,
    "`[certificate]`": schema_certificate.Certificate,
    "`laboratory` and `customer`, of": schema_certificate.Address,
    "`signatures`, of": schema_certificate.Signature,
}


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


# Sessions


@dataclass(frozen=True)
class Step:
    """One command of a session: what is typed, and what the page says it prints."""

    typed: str
    shown: list[str]


def steps(block: str) -> Iterator[Step]:
    for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
        typed, _, shown = part.partition("\n")
        yield Step(typed, shown.rstrip("\n").split("\n") if shown.strip() else [])


@dataclass(frozen=True)
class Begun:
    """What a command gave in an empty folder: exit status, lines, and a copy of the files."""

    status: int
    printed: list[str]
    files: Path


class Session:
    """Play the blocks of a page in the current folder; what several pages begin with is run once, and kept."""

    def __init__(self, begun: dict[str, Begun] | None = None, kept: Path | None = None) -> None:
        self.status = 0
        self.names: dict[str, Any] = {}
        self.begun = {} if begun is None else begun
        self.kept = kept

    def play(self, kind: str, body: str) -> None:
        if kind == "console":
            for step in steps(body):
                printed = self.typed(step.typed)
                gone = [line for line in step.shown if line not in (*printed, ELLIPSIS)]
                assert shows(step.shown, printed), f"{step.typed}: prints no longer {gone}: python docs/refresh.py PAGE"
        elif kind == "python":
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(body, "manual", "exec"), self.names)
        elif kind == "pycon":
            self.example(body)
        elif kind == "{code-block}" and ":caption:" in body:
            head, _, text = body.partition("\n\n")
            file = Path(head.partition(":caption:")[2].split("\n")[0].strip())
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")

    def typed(self, line: str) -> list[str]:
        """Return what a line prints; many pages begin with the same one, which is run for the first of them."""
        if self.kept is None or self.names or any(Path().iterdir()):
            return self.command(shlex.split(line))
        if line not in self.begun:
            printed = self.command(shlex.split(line))
            files = shutil.copytree(".", self.kept / str(len(self.begun)))
            self.begun[line] = Begun(self.status, printed, files)
        else:
            shutil.copytree(self.begun[line].files, ".", dirs_exist_ok=True)
            self.status = self.begun[line].status
        return self.begun[line].printed

    def command(self, words: list[str]) -> list[str]:
        """Return the lines that a command prints; of a refused one the messages too."""
        if words == ["echo", "$?"]:
            return [str(self.status)]
        if words[0] == "cat":
            return Path(words[1]).read_text(encoding="utf-8").rstrip("\n").split("\n")
        assert words[0] == "inertialcal", f"a page types {words[0]!r}"
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), pytest.raises(SystemExit) as left:
            main(words[1:])
        self.status = int(str(left.value.code))
        messages = err.getvalue()
        text = out.getvalue() + (messages[messages.find("error:") :] if self.status in REFUSED else "")
        return [line.rstrip() for line in text.rstrip("\n").split("\n")] if text.strip() else []

    def example(self, body: str) -> None:
        test = doctest.DocTestParser().get_doctest(body, self.names, "manual", None, 0)
        runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
        report = io.StringIO()
        runner.run(test, out=report.write, clear_globs=False)
        self.names.update(test.globs)
        assert not report.getvalue(), report.getvalue()


def shows(shown: list[str], printed: list[str]) -> bool:
    """Whether the parts between ``...`` stand in the output, whole lines, in order, nothing else left out."""
    parts: list[list[str]] = [[]]
    for line in shown:
        if line.strip() == ELLIPSIS:
            parts.append([])
        else:
            parts[-1].append(line.rstrip())
    at = 0
    for number, part in enumerate(parts):
        last = number == len(parts) - 1
        starts = [at] if number == 0 else [len(printed) - len(part)] if last else range(at, len(printed))
        found = next((i for i in starts if i >= at and printed[i : i + len(part)] == part), None)
        if found is None:
            return False
        at = found + len(part)
    return len(parts) > 1 or at == len(printed)


LONG = (
    "commands/demo.md",
    "commands/certificate.md",
    "gallery/figures.md",
    *(f"tutorials/{name}.md" for name in TUTORIALS),
)  # half a minute
READS_REPORTS = ("show.md",)  # for all others campaigns are run without their page, which takes half of the time
PLAYED = [pytest.param(path, marks=[pytest.mark.slow] * path.as_posix().endswith(LONG)) for path in PAGES]


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Begun], Path]:
    return {}, tmp_path_factory.mktemp("begun")


@pytest.mark.parametrize("path", PLAYED, ids=name_of)
def test_what_a_page_shows_is_what_happens(
    path: Path, begun: tuple[dict[str, Begun], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    session = Session(*begun)
    if path.name in READS_REPORTS:
        session = Session({}, begun[1] / "drawn")
    else:
        monkeypatch.setattr("inertialcal.report.page.report_html", lambda *parts: "")
    for block in FENCE.finditer(path.read_text(encoding="utf-8")):
        session.play(block["kind"], block["body"])
    if path.parent.name == "commands":
        try_examples(path, session)


HELP_EXAMPLE = re.compile(r"^ +(inertialcal .+)$", re.MULTILINE)


def examples_of(*words: str) -> list[str]:
    """Commands that the help of a command ends with."""
    shown = io.StringIO()
    with pytest.raises(SystemExit), contextlib.redirect_stdout(shown):
        main([*words, "--help"])
    return HELP_EXAMPLE.findall(shown.getvalue().partition("Examples:")[2])


def help_pages(name: str) -> list[tuple[str, ...]]:
    """Words of the helps that belong to a command."""
    return [(name, test) for test in getattr(COMMANDS[name], "names", list)()] or [tuple(name.split())]


def command_page(name: str) -> str:
    """Name of the page of a command, whose words may be two."""
    return name.replace(" ", "-")


def try_examples(page: Path, session: Session) -> None:
    """Type what the help gives as examples, in the folder with the files that the page has named."""
    played = {step.typed for block in FENCE.finditer(page.read_text("utf-8")) for step in steps(block["body"])}
    for words in help_pages(next(name for name in COMMANDS if command_page(name) == page.stem)):
        for typed in examples_of(*words):
            if typed not in played:
                if words == ("init",):
                    Path("gyros/campaign.toml").unlink(missing_ok=True)  # it writes none over another
                if words in {("check",), ("run",)} and session.status in REFUSED:  # the page has broken its campaign
                    shutil.rmtree("inertialcal-demo")
                    session.command(["inertialcal", "demo", "npsat2011", "--quiet"])
                printed = session.typed(typed)
                assert session.status in {0, 1, 4}, (typed, printed)
                assert not named_twice(typed, printed), (typed, printed)


def named_twice(typed: str, printed: list[str]) -> list[str]:
    """Return the files and folders of a command that its answer names more than once.

    Commands to copy are set aside, and messages, each of which begins with the place in a file that it is about.
    """
    lines = [line for line in printed if not re.match(r"(error|warning|info): ", line)]
    said = "\n".join(re.split(r"inertialcal [a-z]", line)[0] for line in lines)
    paths = {word for word in shlex.split(typed)[2:] if Path(word).exists() and (len(word) > 4 or "." in word)}
    return sorted(one for one in paths if len(re.findall(rf"(?<![\w/.-]){re.escape(one)}(?![\w/-])", said)) > 1)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_help_ends_with_two_examples(name: str) -> None:
    for words in help_pages(name):
        found = examples_of(*words)
        assert len(set(found)) == 2, words
        assert all(one.startswith(f"inertialcal {' '.join(words)} ") for one in found)


def test_an_output_may_leave_out_only_what_it_marks() -> None:
    printed = ["a", "b", "c", "d"]
    assert shows(["a", "...", "d"], printed)
    assert shows(["...", "b", "c", "..."], printed)
    assert shows(printed, printed)
    for wrong in (["a", "b"], ["a", "...", "c"], ["a", "...", "x", "...", "d"], ["c", "...", "d"], ["a", "...", "a"]):
        assert not shows(wrong, printed)


# Tables of keys


def rows_after(page: str, mark: str) -> dict[str, list[str]]:
    """Cells of the first table after a line that begins with a mark, by key; a cell may name several keys."""
    lines = iter(page.split("\n"))
    next(line for line in lines if re.sub(r"^#+ ", "", line).startswith(mark))
    found: dict[str, list[str]] = {}
    for line in lines:
        if line.startswith("| `"):
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
            found |= dict.fromkeys(re.findall(r"`([^`]+)`", cells[0]), cells)
        elif found:
            break
    return found


def as_toml(value: Any) -> str:
    """Return a default as the pages write it."""
    if value is PydanticUndefined or value is None:
        return "none" if value is None else "required"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, str):
        return f'`"{value}"`'
    if isinstance(value, int | float):
        return f"`{value}`"
    if isinstance(value, schema_sensors.Chain):
        return f'`{{ kind = "{value.kind}" }}`'
    return "none" if value == [] else "empty"


def choices(annotation: Any) -> Iterator[str]:
    """Words of every Literal in an annotation."""
    if get_origin(annotation) is Literal:
        yield from (str(one) for one in get_args(annotation))
    else:
        for part in get_args(annotation):
            yield from choices(part)


def _by_axis(word: str, kind: str) -> bool:
    return word in ("x", "y", "z") and ("per axis" in kind or kind == "columns")


@pytest.mark.parametrize("mark", CAMPAIGN_TABLES)
def test_every_key_of_the_campaign_file_is_documented(mark: str) -> None:
    table = rows_after((DOCS / "campaign.md").read_text(encoding="utf-8"), mark)
    known = {field.alias or name: field for name, field in CAMPAIGN_TABLES[mark].model_fields.items()}
    assert list(table) == list(known)
    said = ""
    for key, field in known.items():
        default = {"standards": "none"}.get(key, as_toml(field.default))
        assert table[key][2] == default, f"{key}: the default is {default}"
        said = " ".join([said, *table[key]] if table[key][3].startswith("the same") else table[key])
        for word in choices(field.annotation):
            assert word in said or _by_axis(word, table[key][1]), f"{key}: {word} is not named"


def test_every_standard_is_documented() -> None:
    page = (DOCS / "campaign.md").read_text(encoding="utf-8")
    known = {f"{standard}.{name}" for standard, inner in schema_standards.STANDARDS.items() for name in inner}
    assert set(rows_after(page, "`[standards.NAME]`")) == known


def test_the_schema_has_no_table_without_a_page() -> None:
    assert set(tables_of(schema.CampaignFile)) == set(CAMPAIGN_TABLES.values())


def tables_of(annotation: Any) -> Iterator[type[schema_words.Strict]]:
    """A table of the schema, and all inside it."""
    if isinstance(annotation, type) and issubclass(annotation, schema_words.Strict):
        yield annotation
        for field in annotation.model_fields.values():
            if annotation not in get_args(field.annotation):  # a table of its own kind inside
                yield from tables_of(field.annotation)
    for part in get_args(annotation):
        yield from tables_of(part)


def page_of(procedure: str) -> str:
    """Return what the manual says of a procedure, on one page or on several."""
    pages = sorted((DOCS / "procedures").glob(f"{procedure}*.md"))
    return "\n".join(page.read_text(encoding="utf-8") for page in pages)


@pytest.mark.parametrize("procedure", procedure_names())
def test_every_setting_of_a_plan_is_documented(procedure: str) -> None:
    """Tables are made by ``docs/made.py``; here they are there, and whole."""
    page = page_of(procedure)
    plan = procedure_of(procedure).plan_type
    tables = {f"`{one.name}`:": one.table for one in settings_of(plan) if one.table is not None}
    for mark, kind in {"Settings": plan, **tables}.items():
        assert list(rows_after(page, mark)) == [one.name for one in settings_of(kind)]


@pytest.mark.parametrize("procedure", procedure_names())
def test_every_setting_has_one_plain_sentence(procedure: str) -> None:
    settings = settings_of(procedure_of(procedure).plan_type)
    inner = [two for one in settings if one.table is not None for two in settings_of(one.table)]
    for one in (*settings, *inner):
        assert re.fullmatch(r"[A-Z].*[^.]\.", one.help), one.name
        assert one.example or one.choices or one.flag, f"{one.name}: how is it written?"


# Results


@pytest.fixture(scope="module")
def example(published_report: Path) -> Path:
    return published_report.parents[1]


@pytest.fixture(scope="module")
def results(example: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((example / "out" / "results.json").read_text(encoding="utf-8"))
    return found


def test_every_key_of_the_results_is_documented(results: dict[str, Any], example: Path) -> None:
    page = (DOCS / "results.md").read_text(encoding="utf-8")
    assert set(rows_after(page, "results.json")) == set(results)
    assert set(rows_after(page, "Rows of results")) == set(results["results"][0])
    assert set(rows_after(page, "Verdicts")) == set(results["verdicts"][0])
    assert set(rows_after(page, "Remarks")) == set(results["remarks"][0])
    assert set(rows_after(page, "`closed_loop` holds")) == set(results["closed_loop"]["axes"][0])
    for part in ("covariances", "budgets"):
        assert all(f"`{key}`" in page for key in results[part][0]), part
    (curve, *_) = read_curves((example / "out" / "curves.parquet").read_bytes())
    assert all(f"`{key}`" in page for key in curve)
    for column in (*COLUMNS, *VERDICT_COLUMNS):
        assert f"`{column}`" in page, column


def test_every_file_of_out_is_documented(example: Path) -> None:
    page, out = (DOCS / "results.md").read_text(encoding="utf-8"), example / "out"
    assert set(rows_after(page, "Results: what a run writes")) == set(os.listdir(out))
    record = json.loads((out / "provenance.json").read_text(encoding="utf-8"))
    assert set(rows_after(page, "provenance.json")) == set(record)


def test_every_key_of_json_is_documented() -> None:
    page = (DOCS / "results.md").read_text(encoding="utf-8")
    answer = io.StringIO()
    with contextlib.redirect_stdout(answer), pytest.raises(SystemExit):
        main(["check", "no such folder", "--json"])
    assert set(rows_after(page, "`--json`")) == set(json.loads(answer.getvalue()))


def test_every_key_of_a_survey_is_documented(example: Path) -> None:
    page = (DOCS / "commands" / "info.md").read_text(encoding="utf-8")
    timed = example.parent / "timed.csv"
    timed.write_text("time [s],gyro_x [deg/s]\n" + "".join(f"{n / 10},{n % 3}\n" for n in range(20)), encoding="utf-8")
    found = ic.info(timed).to_dict()
    assert set(rows_after(page, "`results` holds")) == set(found)
    for key in (*found["channels"][0], *found["time"]):
        assert f"`{key}`" in page, key


def test_every_quantity_and_status_is_documented(results: dict[str, Any]) -> None:
    page = (DOCS / "procedures" / "rate_table.md").read_text(encoding="utf-8")
    words = (DOCS / "words.md").read_text(encoding="utf-8")
    for row in results["results"]:
        assert f"`{row['quantity']}`" in page, row["quantity"]
        assert f"`{row['status']}`" in words
        named = {"", *(one["requirement"] for one in results["verdicts"])}
        assert case_name(row) in named or f"`{row['condition']}`" in words, case_name(row)
    for verdict in ("PASS", "FAIL", "INCONCLUSIVE", "OPEN"):
        assert f"| `{verdict}` |" in words


def test_every_quantity_condition_and_curve_of_a_flip_is_documented(tmp_path: Path) -> None:
    page = (DOCS / "procedures" / "flip.md").read_text(encoding="utf-8")
    words, curves = ((DOCS / name).read_text(encoding="utf-8") for name in ("words.md", "results.md"))
    for folder in (build("sams1996", tmp_path / "published"), build("sams_tsh", tmp_path / "simulated")):
        found = ic.run(folder, write=False).results
        for row in found["results"]:
            assert f"`{row['quantity']}`" in (words if row["test"] == "model" else page), row["quantity"]
            told = re.sub(r"flip \d+$", "flip 1", case_name(row))
            assert not told or f"`{told}`" in words, case_name(row)
        for curve in found["curves"]:
            columns = rows_after(curves, "A curve has")[curve["name"]][2]
            assert all(f"`{name}`" in columns for name in curve["columns"]), curve["name"]


def test_every_quantity_condition_and_curve_of_noise_is_documented(tmp_path: Path) -> None:
    page = (DOCS / "procedures" / "static_noise.md").read_text(encoding="utf-8")
    words, curves = ((DOCS / name).read_text(encoding="utf-8") for name in ("words.md", "results.md"))
    found = ic.run(build("still_gyro", tmp_path / "still"), write=False).results
    for row in found["results"]:
        told = re.sub("run .* alone", "run NAME alone", case_name(row))
        assert f"`{row['quantity']}`" in page, row["quantity"]
        assert not told or f"`{told}`" in words, case_name(row)
    for curve in found["curves"]:
        columns = rows_after(curves, "A curve has")[curve["name"]][2]
        terms = {name for name in curve["columns"] if f"`{name}`" in page}
        assert all(f"`{name}`" in columns for name in set(curve["columns"]) - terms), curve["name"]


def test_every_quantity_condition_and_curve_of_a_moved_mass_is_documented(tmp_path: Path) -> None:
    page = page_of("mass_attraction")
    words, curves = ((DOCS / name).read_text(encoding="utf-8") for name in ("words.md", "results.md"))
    for folder in (build("reinel1969", tmp_path / "published"), build("mesa", tmp_path / "simulated")):
        found = ic.run(folder, write=False).results
        for row in found["results"]:
            told = re.sub("run .* alone", "run NAME alone", case_name(row))
            assert f"`{row['quantity']}`" in (words if row["test"] == "model" else page), row["quantity"]
            assert not told or f"`{told}`" in words, case_name(row)
        for curve in found["curves"]:
            columns = rows_after(curves, "A curve has")[curve["name"]][2]
            assert all(f"`{name}`" in columns for name in curve["columns"]), curve["name"]


def test_every_remark_of_a_procedure_is_documented() -> None:
    code = re.compile(r'Remark\(\s*"(\w+)"')
    results_page = (DOCS / "results.md").read_text(encoding="utf-8")
    for procedure in procedure_names():
        page = page_of(procedure) + results_page
        for module in (SOURCE / "procedures" / procedure).glob("*.py"):
            for word in code.findall(module.read_text(encoding="utf-8")):
                assert f"`{word}`" in page, f"{procedure}: remark {word}"
    assert all(f"`{key}`" in results_page for key in Remark("code", "info", "what").to_dict())


# Commands and Python


def test_every_command_has_a_page_and_every_page_a_command() -> None:
    assert {page.stem for page in (DOCS / "commands").glob("*.md")} == {command_page(name) for name in COMMANDS}


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_is_named_on_the_page_of_its_command(name: str) -> None:
    page = (DOCS / "commands" / f"{command_page(name)}.md").read_text(encoding="utf-8")
    tests = {
        word: TYPED.get_command(None, name).get_command(None, word) for word in getattr(COMMANDS[name], "names", list)()
    }  # of a command for several: plan mass-attraction
    for mark, command in {f"Options of {name} {test}": one for test, one in tests.items()}.items() or [
        ("Options", COMMANDS[name])
    ]:
        table = {key.split()[0] for key in rows_after(page, mark)}
        known = {"--help"}
        for parameter in command.params:
            options = [*parameter.opts, *parameter.secondary_opts]
            known |= {str(parameter.name).upper()} if parameter.param_type_name == "argument" else set(options)
        assert table == known, mark


def test_every_setting_of_a_planner_stands_in_the_manual_as_it_is_declared() -> None:
    page = (DOCS / "commands" / "plan.md").read_text(encoding="utf-8")
    table = rows_after(page, "Settings of plan mass-attraction")
    for key, example, default, about in settings_table(Settings):
        assert table[key] == [f"`{key}`", f"`{example}`", default or "-", about]
    assert set(table) == {key for key, *_ in settings_table(Settings)}


@pytest.mark.parametrize("path", PAGES, ids=name_of)
def test_a_page_names_only_commands_that_exist(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    for word in re.findall(r"(?:`|^\$ |^)inertialcal ([a-z][\w-]*)", text, re.MULTILINE):
        assert word in {one.split()[0] for one in COMMANDS}, f"{path.name}: inertialcal {word}"


def test_every_exit_status_is_documented() -> None:
    table = re.findall(r"^\| (\d+) \|", (DOCS / "words.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert table == ["0", "1", "2", "3", "4", "70", "130"]


def test_every_public_name_is_documented() -> None:
    api, python = ((DOCS / name).read_text(encoding="utf-8") for name in ("api.md", "python.md"))
    listed = dict(reversed(one) for one in re.findall(r"auto(function|class|exception):: inertialcal\.(\w+)\n", api))
    assert sorted(listed) == sorted(ic.__all__)
    assert [name for name in dir(ic) if not name.startswith("__")] == sorted(ic.__all__)  # what an editor offers
    for name, kind in listed.items():
        assert (kind == "function") != isinstance(getattr(ic, name), type), name
        assert kind != "function" or f"ic.{name}(" in python


@pytest.mark.parametrize("path", PAGES, ids=name_of)
def test_links_to_files_lead_somewhere(path: Path) -> None:
    for target in re.findall(r"\]\(([^)#\s]+)", path.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (path.parent / target).exists(), f"{path.name}: {target}"


@pytest.mark.parametrize("path", PAGES, ids=name_of)
def test_pages_need_no_network(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert "{math}" not in text  # drawn by a script from the network
    assert "$$" not in text
