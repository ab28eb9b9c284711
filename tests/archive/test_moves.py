"""Archives moved between databases, through schemas, by two at once and through a kill; what is changed is found."""

from __future__ import annotations

import io
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from made_records import add, content, figure, record, yearly
from sqlalchemy import text

from inertialcal.archive import open_archive
from inertialcal.archive.archive import Archive
from inertialcal.archive.exchange import read_export
from inertialcal.archive.record import read_record
from inertialcal.campaign.engine.run import run
from inertialcal.core.errors import DataError, StoreError, UsageError
from sized import sized

KINDS = ("sqlite", "postgresql")
PROCESSES = ("sqlite", pytest.param("postgresql", marks=pytest.mark.slow))  # where others write at the same time
HELPER = Path(__file__).parent


@pytest.fixture
def empty(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[[str], Archive]:
    """Make an empty archive in a database of a kind."""
    count = iter(range(100))

    def made(kind: str) -> Archive:
        if kind == "sqlite":
            return open_archive(tmp_path / f"lab{next(count)}.db")
        new: Callable[[], str] = request.getfixturevalue("postgres")
        return open_archive(new())

    return made


def filled(archive: Archive) -> Archive:
    """An archive with versions, texts of all kinds, numbers of all digits."""
    first = content("A", 0.0, [figure(0.1 + 2**-50, 1.0 / 3.0), figure(-0.0, 5e-99, "bias", unit="deg/s", dof=4.5)])
    first["item"] |= {"owner": "Ωwner \U0001f6f0", "lot": "L1"}
    other = content("A", 0.0, [figure(1.7976931348623157e99, 1e-90)], verdict="FAIL")
    add(archive, first, other, first, *yearly("B\u202e\x1b'; --", [0.1, 0.2, 0.3]))
    return archive


def every(archive: Archive) -> list[bytes]:
    with archive.database.reading() as connection:
        return [read_record(connection, one.number).lines() for one in archive.list().campaigns]


def said(archive: Archive) -> list[tuple[object, ...]]:
    with archive.database.reading() as connection:
        columns = "name, version, replaces, added_ns, record_sha256, chain"
        return [tuple(row) for row in connection.execute(text(f"SELECT {columns} FROM campaigns ORDER BY id"))]


@pytest.mark.parametrize(("one", "other"), [(a, b) for a in KINDS for b in KINDS if a != b or a == "sqlite"])
def test_nothing_is_lost_between_databases(
    one: str, other: str, empty: Callable[[str], Archive], tmp_path: Path
) -> None:
    source, target = filled(empty(one)), empty(other)
    moved = source.export(tmp_path / "one.zip")
    there = target.import_(tmp_path / "one.zip")
    assert (there.campaigns, there.there, there.chain) == (moved.campaigns, 0, moved.chain)
    assert every(target) == every(source)
    assert said(target) == said(source)
    target.export(tmp_path / "two.zip")
    assert (tmp_path / "two.zip").read_bytes() == (tmp_path / "one.zip").read_bytes()
    assert target.import_(tmp_path / "one.zip").there == moved.campaigns
    assert not target.verify().problems


def test_an_import_adds_to_what_is_there(empty: Callable[[str], Archive], tmp_path: Path) -> None:
    source, target = filled(empty("sqlite")), empty("sqlite")
    add(target, *yearly("Z", [0.5]))
    source.export(tmp_path / "one.zip")
    target.import_(tmp_path / "one.zip")
    assert {one.serial for one in target.list().campaigns} == {"A", "B\u202e\x1b'; --", "Z"}
    assert not target.verify().problems


def changed(path: Path, name: str, change: Callable[[bytes], bytes]) -> Path:
    """A copy of an export with one part changed, its sums as they were."""
    made = io.BytesIO()
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(made, "w") as new:
        for one in old.namelist():
            data = old.read(one)
            new.writestr(one, change(data) if one == name else data)
    copy = path.with_name("changed.zip")
    copy.write_bytes(made.getvalue())
    return copy


def test_an_export_that_was_changed_is_refused(empty: Callable[[str], Archive], tmp_path: Path) -> None:
    path = tmp_path / "one.zip"
    filled(empty("sqlite")).export(path)
    target = empty("sqlite")
    wrong = [changed(path, "records.jsonl", lambda data: data.replace(b"0.2", b"0.9"))]
    for each in wrong:
        with pytest.raises(DataError, match=r"records.jsonl has another SHA-256"):
            target.import_(each)
    with pytest.raises(DataError, match="another SHA-256"):
        target.import_(changed(path, "SHA256SUMS", lambda data: data[:0]))
    for data in (b"", b"PK", path.read_bytes()[:2000], b"{}" * 50):
        path.with_name("other.zip").write_bytes(data)
        with pytest.raises(DataError):
            target.import_(path.with_name("other.zip"))
    with pytest.raises(StoreError):
        target.list()  # nothing of it was added


def test_names_in_an_export_are_no_paths(empty: Callable[[str], Archive], tmp_path: Path) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as new:
        new.writestr("../../escaped", b"x")
        new.writestr("SHA256SUMS", b"")
    (inner / "evil.zip").write_bytes(made.getvalue())
    with pytest.raises(DataError):
        read_export(inner / "evil.zip")
    assert not (tmp_path / "escaped").exists()


@pytest.mark.parametrize("kind", KINDS)
def test_schemas_both_ways(kind: str, empty: Callable[[str], Archive]) -> None:
    """An archive of the first version, made by its own migration, is brought to the newest, back, and there again."""
    from inertialcal.archive.migrate import downgrade, upgrade

    archive = empty(kind)
    with archive.database.writing(migrating=True) as connection:
        upgrade(connection, "0001")
        connection.execute(text("INSERT INTO items VALUES (1, 'Maker', 'G1', 'A', 'me')"))
        names = "id, item_id, name, version, title, owner, verdict, program, folder, results_sha256, added_ns"
        connection.execute(text(f"INSERT INTO campaigns ({names}, record_sha256, chain) VALUES "
                                "(1, 1, 'old', 1, '', 'me', '', '0.2.0', '/lab', 'x', 7, 'x', 'x')"))  # fmt: skip
    with pytest.raises(StoreError, match="archive migrate"):
        archive.list()
    assert archive.migrate() == ("0001", "0002")
    assert [(one.name, one.owner) for one in archive.list().campaigns] == [("old", "me")]
    if kind == "postgresql":
        with archive.database.writing() as connection:  # numbers were given by hand
            for table in ("items", "campaigns"):
                connection.execute(text(f"SELECT setval(pg_get_serial_sequence('{table}', 'id'), 10)"))
    add(archive, *yearly("B", [0.1, 0.2]))
    before = every(archive)
    assert archive.migrate("0001") == ("0002", "0001")
    with pytest.raises(StoreError, match="archive migrate"):
        add(archive, *yearly("C", [0.1]))
    archive.migrate()
    assert every(archive) == before
    assert archive.history("B").series[0].last.row.value == 0.2
    with pytest.raises(UsageError, match="no schema '7'"):
        archive.migrate("7")
    with archive.database.writing(migrating=True) as connection:
        downgrade(connection, "base")
    with pytest.raises(StoreError, match="no archive here"):
        archive.list()


@pytest.mark.parametrize("kind", KINDS)
def test_what_the_migrations_make_is_what_the_program_expects(kind: str, empty: Callable[[str], Archive]) -> None:
    from alembic.autogenerate import compare_metadata
    from alembic.migration import MigrationContext

    from inertialcal.archive.tables import metadata

    archive = filled(empty(kind))
    with archive.database.reading() as connection:
        found = compare_metadata(MigrationContext.configure(connection, opts={"compare_type": True}), metadata)
    assert [one for one in found if "remove_column" not in str(one)] == []


WRONG = {
    "UPDATE results SET value = 0.25 WHERE value = 0.2": "results, row 0: value is 0.25, results.json says 0.2",
    "DELETE FROM results WHERE value = 0.2": "results, row 0 is missing",
    "UPDATE standards SET certificate = 'C-9'": "standards, row 0: certificate is 'C-9'",
    "UPDATE campaigns SET verdict = 'PASS' WHERE verdict = 'FAIL'": "verdict is 'PASS', results.json says 'FAIL'",
    "UPDATE campaigns SET record_sha256 = 'x' WHERE id = 2": "a campaign before it is missing, or was put there",
    "UPDATE files SET content = NULL WHERE sha256 = (SELECT MIN(sha256) FROM files)": "",
    "UPDATE files SET size = 3 WHERE sha256 = (SELECT MIN(sha256) FROM files)": "is damaged",
}


@pytest.mark.parametrize("statement", WRONG)
def test_what_is_changed_or_missing_is_named(statement: str, empty: Callable[[str], Archive]) -> None:
    archive = filled(empty("sqlite"))
    assert not archive.verify().problems
    with archive.database.writing() as connection:
        assert connection.execute(text(statement)).rowcount
    found = archive.verify()
    assert found.problems or "NULL" in statement
    assert WRONG[statement] in str(found)


def test_a_campaign_that_was_taken_out_is_missed(empty: Callable[[str], Archive]) -> None:
    archive = filled(empty("sqlite"))
    with archive.database.writing(migrating=True) as connection:
        for table in ("tests", "results", "standards", "uses"):
            connection.execute(text(f"DELETE FROM {table} WHERE campaign_id = 5"))
        connection.execute(text("DELETE FROM campaigns WHERE id = 5"))
    assert [one.code for one in archive.verify().problems] == ["chain"]


def test_the_newest_campaigns_taken_out_are_missed_with_a_receipt(
    empty: Callable[[str], Archive], tmp_path: Path
) -> None:
    archive, receipt = filled(empty("sqlite")), tmp_path / "receipt.json"
    receipt.write_text(json.dumps({"verified": archive.verify().to_dict()}))
    add(archive, *yearly("later", [0.1]))
    assert not archive.verify(receipt).problems  # more may have come since
    with archive.database.writing(migrating=True) as connection:
        for table in ("tests", "results", "standards", "uses"):
            connection.execute(text(f"DELETE FROM {table} WHERE campaign_id > 4"))
        connection.execute(text("DELETE FROM campaigns WHERE id > 4"))
    assert not archive.verify().problems
    (said,) = archive.verify(receipt).problems
    assert "2 of 6 campaigns" in said.what
    add(archive, *yearly("others", [0.1, 0.2, 0.3]))
    (said,) = archive.verify(receipt).problems
    assert "not those of the receipt" in said.what
    for wrong in ("x", "[]", '{"verified": 3}', '{"verified": {"campaigns": "many"}}'):
        receipt.write_text(wrong)
        with pytest.raises(DataError, match="not a receipt"):
            archive.verify(receipt)


@pytest.mark.usefixtures("undrawn")
def test_a_recording_that_was_changed_is_found(campaign: Callable[..., Path], tmp_path: Path) -> None:
    folder, archive = campaign(), open_archive(tmp_path / "lab.db")
    run(folder)
    archive.add(folder)
    assert archive.verify().recordings == 1
    (folder / "one.csv").write_text("other", encoding="utf-8")
    assert "recording one.csv was changed" in str(archive.verify())
    shutil.rmtree(folder / "out")
    (folder / "one.csv").unlink()
    assert archive.verify().away == 1


@pytest.mark.usefixtures("undrawn")
def test_two_campaigns_of_an_archive_compare_as_their_folders_do(campaign: Callable[..., Path], tmp_path: Path) -> None:
    from inertialcal.campaign.compare.compare import compare

    archive, copy = open_archive(tmp_path / "lab.db"), tmp_path / "before"
    folder = campaign()
    run(folder)
    first = archive.add(folder)
    copy.mkdir()
    for name in ("campaign.toml", "one.csv", "out"):
        (shutil.copytree if name == "out" else shutil.copy)(folder / name, copy / name)
    run(campaign(('id = "small"', 'id = "later"'), ('u = "0.05 %"', 'u = "0.07 %"')))
    second = archive.add(folder)
    found, expected = archive.compare(first.number, second.number), compare(copy, folder)
    assert [one.to_dict() for one in found.differences] == [one.to_dict() for one in expected.differences]
    with pytest.raises(DataError, match="no campaign of number 99"):
        archive.compare(first.number, 99)


ADDING = """
import sys
from made_records import add, yearly
from inertialcal.archive import open_archive
archive, which = open_archive(sys.argv[1]), sys.argv[2]
print("ready", flush=True)
sys.stdin.readline()
for i in range(int(sys.argv[3])):
    add(archive, *yearly(f"{which}{i}", [0.1, 0.2]))
    add(archive, *yearly("same", [0.1]))
"""


def adding(url: str, which: str, count: int) -> subprocess.Popen[str]:
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(HELPER), *sys.path])}
    command = [sys.executable, "-c", ADDING, url, which, str(count)]
    pipe = subprocess.PIPE
    started = subprocess.Popen(command, env=env, stdin=pipe, stdout=pipe, text=True)
    assert started.stdout is not None
    assert started.stdout.readline() == "ready\n"
    return started


@pytest.mark.parametrize("kind", PROCESSES)
def test_two_add_at_once(kind: str, empty: Callable[[str], Archive]) -> None:
    archive, count = empty(kind), 5
    url = archive.database.url.render_as_string(hide_password=False) if kind != "sqlite" else archive.database.name
    both = [adding(url, which, count) for which in "ab"]
    for one in both:
        assert one.stdin is not None
        one.stdin.write("go\n")
        one.stdin.flush()
    for one in both:
        assert one.wait(120) == 0
        for stream in (one.stdin, one.stdout):
            assert stream is not None
            stream.close()
    listed = archive.list().campaigns
    assert len(listed) == 2 * 2 * count + 1
    assert [one.version for one in listed if one.serial == "same"] == [1]
    assert not archive.verify().problems


@pytest.mark.parametrize("kind", PROCESSES)
def test_a_kill_leaves_a_whole_record_or_nothing_of_it(kind: str, empty: Callable[[str], Archive]) -> None:
    archive = empty(kind)
    add(archive, *yearly("first", [0.1]))
    url = archive.database.url.render_as_string(hide_password=False) if kind != "sqlite" else archive.database.name
    for turn in range(sized(20, 2)):
        one = adding(url, f"k{turn}-", 1000)
        assert one.stdin is not None
        assert one.stdout is not None
        one.stdin.write("go\n")
        one.stdin.flush()
        time.sleep(0.05 + 0.037 * turn)
        one.send_signal(signal.SIGKILL)
        one.wait(30)
        one.stdin.close()
        one.stdout.close()
        assert not archive.verify().problems
        assert add(archive, *yearly(f"after{turn}", [0.1]))[0].new
    counts: dict[str, int] = {}
    for listed in archive.list().campaigns:
        counts[listed.serial] = counts.get(listed.serial, 0) + 1
    assert all(n == 2 for serial, n in counts.items() if serial.startswith("k"))  # both of a transaction, or none


def test_an_export_reads_as_plain_json(empty: Callable[[str], Archive], tmp_path: Path) -> None:
    filled(empty("sqlite")).export(tmp_path / "one.zip")
    with zipfile.ZipFile(tmp_path / "one.zip") as opened:
        lines = [json.loads(one) for one in opened.read("records.jsonl").splitlines()]
        about = json.loads(opened.read("archive.json"))
    assert about["campaigns"] == sum(table == "campaign" for table, _ in lines) == 6
    assert record(yearly("B", [0.1])[0]).sha256  # a record has one hash wherever it is
