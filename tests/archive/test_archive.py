"""An archive: once, a changed run as a new version, whole or nothing, histories; on both databases."""

from __future__ import annotations

import os
import sqlite3
import stat
from collections.abc import Callable
from pathlib import Path

import pytest
from made_records import add, content, figure, record, yearly

from inertialcal.archive import open_archive
from inertialcal.archive.archive import Archive
from inertialcal.archive.record import read_record
from inertialcal.archive.trend import By
from inertialcal.campaign.engine.run import run
from inertialcal.core.errors import DataError, StoreError, UsageError
from inertialcal.report.plot import pictures

pytestmark = pytest.mark.usefixtures("undrawn")


@pytest.fixture(params=["sqlite", "postgresql"])
def archive(request: pytest.FixtureRequest, tmp_path: Path) -> Archive:
    """An archive that is not yet there, in each of the two databases."""
    if request.param == "sqlite":
        return open_archive(tmp_path / "lab.db")
    made: Callable[[], str] = request.getfixturevalue("postgres")
    return open_archive(made())


def test_a_run_is_added_once_and_a_changed_one_as_a_new_version(
    archive: Archive, campaign: Callable[..., Path], tmp_path: Path
) -> None:
    folder = campaign()
    run(folder)
    first = archive.add(folder)
    assert (first.new, first.version, first.replaces) == (True, 1, None)
    again = archive.add(folder)
    assert (again.new, again.number) == (False, first.number)
    run(campaign(('u = "0.05 %"', 'u = "0.06 %"')))
    second = archive.add(folder)
    assert (second.new, second.version, second.replaces) == (True, 2, first.number)
    listed = archive.list().campaigns
    assert [(one.version, one.replaced) for one in listed] == [(1, True), (2, False)]
    assert [one.serial for one in listed] == ["7", "7"]
    run(campaign())
    assert archive.add(folder).replaces == second.number  # back to what it was is a change, too


def test_what_was_added_is_read_back_to_the_last_bit(
    archive: Archive, campaign: Callable[..., Path], tmp_path: Path
) -> None:
    folder = campaign()
    outcome = run(folder)
    number = archive.add(folder).number
    with archive.database.reading() as connection:
        found = read_record(connection, number)
    values = [(row["value"], row["u"]) for row in found.rows["results"]]
    assert values == [(row["value"], row["u"]) for row in outcome.results["results"]]
    assert found.contents[found.run["results_sha256"]] == (folder / "out/results.json").read_bytes()
    assert found.contents[outcome.inputs["campaign.toml"]] == (folder / "campaign.toml").read_bytes()
    assert {use["sha256"] for use in found.rows["uses"]} >= set(outcome.inputs.values())
    assert found.rows["standards"][0]["certificate"] == "C-1"


def test_results_that_were_edited_or_never_made_are_refused(campaign: Callable[..., Path], tmp_path: Path) -> None:
    folder, archive = campaign(), open_archive(tmp_path / "lab.db")
    with pytest.raises(DataError) as refused:
        archive.add(folder)
    assert refused.value.problems[0].code == "no_results"
    run(folder)
    model = folder / "out/verdicts.csv"
    model.write_text(model.read_text() + "\n", encoding="utf-8")
    with pytest.raises(DataError) as refused:
        archive.add(folder)
    assert refused.value.problems[0].code == "edited_by_hand"
    assert not (tmp_path / "lab.db").exists()


def test_history_of_a_unit_uses_the_standard_that_its_tests_share(archive: Archive) -> None:
    """Of two tests, before an adjustment of 2017: no residual, and the stated uncertainties count."""
    values = [0.10, 0.14, 0.50]
    add(archive, *yearly("A", values))
    add(archive, *(content("B", i, [figure(v, 0.0316227766, shared={"rate_table.rate": 0.03})], certificate=f"C-{i}")
                   for i, v in enumerate(values)))  # fmt: skip
    one, other = (archive.history(serial, adjusted=["2017-01-01"]).series[0] for serial in "AB")
    assert one.line is not None
    assert other.line is not None
    assert one.line.slope == pytest.approx(0.04, rel=1e-4)
    assert one.line.u == pytest.approx(0.01 * 2**0.5, rel=1e-4)  # without the error of the table: 0.01 a test
    assert other.line.u == pytest.approx((0.01**2 + 0.03**2) ** 0.5 * 2**0.5, rel=1e-4)  # a certificate each: with it
    assert one.drift is not None
    assert one.drift.unit == "%/year"
    assert one.word == "drift"
    assert other.word == "no drift shown"


LONG = [0.1012345678, 0.1198765432, 0.1412345671, 0.1587654321, 0.1801234567, 0.2012345679, 0.2198765431]


def words_of(archive: Archive, serial: str, **more: list[str]) -> tuple[str, list[str]]:
    """Return the word on the drift, and the codes of remarks."""
    found = archive.history(serial, **more)  # type: ignore[arg-type]
    return found.series[0].word, [one.code for one in found.remarks]


def test_what_is_no_line_is_said_and_nothing_is_forecast(tmp_path: Path) -> None:
    archive = open_archive(tmp_path / "lab.db")
    jumped = [value + 0.5 * (i > 3) for i, value in enumerate(LONG)]
    odd = [value * (57.3 if i == 2 else 1.0) for i, value in enumerate(LONG)]
    bent = [0.2 * (1.0 - 0.5**i) + 0.001 * (-1) ** i for i in range(8)]
    for serial, values in {"line": LONG, "jump": jumped, "odd": odd, "bend": bent}.items():
        add(archive, *yearly(serial, values))
    assert words_of(archive, "line") == ("drift", [])
    assert words_of(archive, "jump") == ("jumps", ["jumps"])
    assert words_of(archive, "odd") == ("odd test", ["odd_test"])
    assert words_of(archive, "bend") == ("bends", ["bends"])
    found = archive.history("jump", limits=["0.1 %"])
    assert found.series[0].due is None
    assert "no line" in str(found)
    (said,) = found.remarks
    assert "between 2018-06-01 and 2019-06-01" in said.what
    assert "--adjusted 2019-06-01" in said.do
    (drawn,) = pictures(found)
    assert drawn.finding == "scale factor error x: jumps, no line"
    assert archive.history("jump", adjusted=["2019-06-01"]).series[0].since == 4
    word, codes = words_of(archive, "jump", adjusted=["2019-06-01"])
    assert (word, codes) == ("drift", [])


def test_a_copied_campaign_counts_once(tmp_path: Path) -> None:
    archive = open_archive(tmp_path / "lab.db")
    made = yearly("A", LONG)
    copy = content("A", 9.0, made[2]["results"])
    add(archive, *made, copy)
    found = archive.history("A")
    assert [one.row.value for one in found.series[0].points] == LONG
    (said,) = found.remarks
    assert (said.code, said.count, said.where) == ("copied", 1, "A-9")
    assert "campaign A-2" in said.what


def test_figures_of_another_kind_of_unit_are_counted(tmp_path: Path) -> None:
    archive = open_archive(tmp_path / "lab.db")
    other = content("A", 0.5, [figure(0.1, 0.01, unit="deg/s")], influences={})
    add(archive, other, *yearly("A", LONG))
    found = archive.history("A")
    assert len(found.series[0].points) == len(LONG)
    assert [(one.code, one.count) for one in found.remarks] == [("other_dimension", 1)]


def test_a_version_that_was_replaced_counts_no_more(archive: Archive) -> None:
    first, second, third = yearly("A", [0.1, 0.2, 0.3])
    add(archive, first, second, third)
    add(archive, content("A", 2.0, [figure(0.9, 0.03, shared={"rate_table.rate": 0.03})]))
    assert [one.row.value for one in archive.history("A").series[0].points] == [0.1, 0.2, 0.9]


def test_units_of_one_serial_number_are_told_apart_by_their_part(tmp_path: Path) -> None:
    archive = open_archive(tmp_path / "lab.db")
    one, other = yearly("A", [0.1]), yearly("A", [0.2])
    other[0]["item"]["part"] = "G2"
    add(archive, *one, *other)
    with pytest.raises(UsageError, match="Say of which part"):
        archive.history("A")
    assert archive.history("A", part="G2").series[0].last.row.value == 0.2
    with pytest.raises(DataError, match="no unit of serial number 'Z'"):
        archive.history("Z")
    with pytest.raises(DataError, match="no figure of bias"):
        archive.history("A", part="G1", quantity="bias")


def test_when_to_calibrate_again(tmp_path: Path) -> None:
    archive = open_archive(tmp_path / "lab.db")
    add(archive, *yearly("A", [0.10, 0.121, 0.139, 0.16, 0.181, 0.199, 0.22, 0.24]))
    found = archive.history("A", limits=["0.1 %"])
    due = found.series[0].due
    assert due is not None
    assert due.first is not None
    assert due.expected is not None
    assert due.last is not None
    assert due.expected == pytest.approx(5.0, rel=0.03)  # 0.1 % at 0.02 % a year
    assert 2.5 < due.first < due.expected < due.last < 8.0
    assert found.due_ns is not None
    assert "calibrate again by 20" in str(found)
    assert archive.history("A", limits=["0.001 %"]).series[0].due.first == 0.0  # type: ignore[union-attr]


def test_histories_and_trends_are_drawn(tmp_path: Path) -> None:
    from inertialcal.report.figure_file import write_figure

    archive = open_archive(tmp_path / "lab.db")
    for i in range(24):
        add(archive, *yearly(f"$U{i}$", [0.10 + 0.01 * i, 0.121, 0.139], lot=f"L{i // 6}"))
    history = archive.history("$U3$", limits=["0.1 %"])
    (one,) = pictures(history)
    assert one.finding.startswith("scale factor error x: ")
    kinds: tuple[By, ...] = ("unit", "lot")
    for by in kinds:
        (chart,) = pictures(archive.trend("scale_factor_error", by=by))
        assert f"{by}s" in chart.finding
        write_figure(tmp_path / f"{by}.png", [one, chart], [])
        assert (tmp_path / f"{by}.png").stat().st_size > 10_000


def test_units_of_texts_that_no_table_should_show_are_kept(archive: Archive) -> None:
    evil = "x'; DROP TABLE items; --\u202e\x1b[31m%s{}"
    add(archive, *yearly(evil, [0.1, 0.2]))
    assert len(archive.list(evil).campaigns) == 2
    assert archive.history(evil).series[0].last.row.value == 0.2
    assert "\x1b" not in str(archive.list()) + str(archive.history(evil))


def test_a_transaction_that_is_broken_off_leaves_nothing(archive: Archive) -> None:
    add(archive, *yearly("A", [0.1]))
    with pytest.raises(RuntimeError), archive.database.writing() as connection:  # noqa: PT012
        from inertialcal.archive.archive import add_record

        add_record(connection, record(yearly("B", [0.1])[0]), "made", 0)
        raise RuntimeError
    assert [one.serial for one in archive.list().campaigns] == ["A"]


@pytest.mark.parametrize(
    "url",
    ["postgresql://me:s3cret@localhost:1/lab", "postgresql://me:s3@cret@host/lab", "mysql://me:s3cret@host/lab",
     "postgresql://me:s3cret@host:port/lab", "postgresql://me@localhost:1/lab?password=s3cret", "://s3cret"],
)  # fmt: skip
def test_no_password_is_ever_printed(url: str) -> None:
    with pytest.raises((StoreError, UsageError)) as refused:
        open_archive(url).list()
    said = "".join(str(refused.value.problems) + str(refused.value) + repr(refused.value.__cause__))
    assert "s3" not in said
    assert "cret" not in said


def test_files_that_are_no_archive_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "lab.db"
    for data, code in ((None, "no_archive"), (b"", "no_archive"), (b"words, and no database" * 99, "not_an_archive")):
        if data is not None:
            path.write_bytes(data)
        with pytest.raises(StoreError) as refused:
            open_archive(path).list()
        assert refused.value.problems[0].code == code
    path.unlink()
    with sqlite3.connect(path) as other:
        other.execute("CREATE TABLE items (id INTEGER)")
    with pytest.raises(StoreError, match="its tables have the names of ours"):
        add(open_archive(path), *yearly("A", [0.1]))
    with pytest.raises(StoreError, match="no such folder"):
        add(open_archive(tmp_path / "none/lab.db"), *yearly("A", [0.1]))


def test_a_newer_schema_is_refused(archive: Archive) -> None:
    add(archive, *yearly("A", [0.1]))
    with archive.database.writing() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '0999'")
    for use in (archive.list, lambda: add(archive, *yearly("B", [0.1]))):
        with pytest.raises(StoreError, match="a newer inertialcal has made it") as refused:
            use()
        assert refused.value.problems[0].code == "schema_version"


def test_a_lock_of_another_program_is_waited_for_and_then_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("inertialcal.archive.database.WAIT", 0.1)
    archive = open_archive(tmp_path / "lab.db")
    add(archive, *yearly("A", [0.1]))
    other = sqlite3.connect(tmp_path / "lab.db", isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    assert archive.list().campaigns  # who reads need not wait
    with pytest.raises(StoreError) as refused:
        add(archive, *yearly("B", [0.1]))
    assert refused.value.problems[0].code == "locked"
    other.execute("ROLLBACK")
    add(archive, *yearly("B", [0.1]))
    other.close()


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="permissions of POSIX")
def test_an_archive_that_cannot_be_written_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "kept"
    folder.mkdir()
    path = folder / "lab.db"
    add(open_archive(path), *yearly("A", [0.1]))
    path.chmod(stat.S_IRUSR)
    folder.chmod(stat.S_IRUSR | stat.S_IXUSR)
    if not os.getuid():  # root may write everything: as any other user sees it
        monkeypatch.setattr(os, "access", lambda *_: False)
    assert [one.serial for one in open_archive(path).list().campaigns] == ["A"]
    if os.getuid():
        with pytest.raises(StoreError) as refused:
            add(open_archive(path), *yearly("B", [0.1]))
        assert refused.value.problems[0].code in {"read_only", "not_accessible"}
    folder.chmod(stat.S_IRWXU)
