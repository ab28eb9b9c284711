"""A certificate says what the campaign states and was measured, or is refused: what lacks, what it could lie about."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from certified import NAMESPACES, STATED, Schemas, compiled, made, state

import inertialcal as ic
from inertialcal.campaign.certificate.content import content_of
from inertialcal.campaign.certificate.missing import NEEDED, OF_ITEM
from inertialcal.campaign.certificate.periods import period_of
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.load import load
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError, InertialcalError, PlanError, UsageError
from inertialcal.core.schema.checksum import checksum
from inertialcal.files.xml_text import xml_root
from inertialcal.rigs.twin import SEED
from npsat1_small import short_twin

pytestmark = pytest.mark.usefixtures("undrawn")
VALID = ('certificate = "C-1"', 'certificate = "C-1", valid = "2026-01-01 to 2026-12-31"')
KEPT: dict[str, Path] = {}


@pytest.fixture
def small(tmp_path: Path, campaign: Callable[..., Path]) -> Path:
    """A campaign that was run, and states all; a copy of its own for each test."""
    if "small" not in KEPT:
        KEPT["small"] = made("small", tmp_path, lambda: campaign(VALID))
        KEPT["copy"] = tmp_path.with_name("kept_of_small")
        shutil.copytree(tmp_path, KEPT["copy"])
    return Path(shutil.copytree(KEPT["copy"], tmp_path, dirs_exist_ok=True))


def code_of(call: Callable[[], object]) -> str:
    with pytest.raises(InertialcalError) as refused:
        call()
    return refused.value.problems[0].code


def replace(folder: Path, old: str, new: str) -> None:
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def put(stated: dict[str, Any], key: str, value: Any) -> None:
    table, _, name = key.rpartition(".")
    (stated[table] if table else stated)[name] = value


# What is not stated


def test_all_that_lacks_is_listed_at_once_before_anything_is_made(small: Path) -> None:
    text = (small / "campaign.toml").read_text(encoding="utf-8")
    (small / "campaign.toml").write_text(text.partition("\n[certificate]")[0], encoding="utf-8")
    replace(small, 'maker = "of a test"\n', "")
    shutil.rmtree(small / "out")  # it is listed before a run, too
    with pytest.raises(PlanError) as refused:
        ic.certificate(small, small / "c.pdf")
    assert [one.code for one in refused.value.problems] == ["not_stated"] * (1 + len(NEEDED))
    assert refused.value.exit_status == 3
    assert not (small / "c.pdf").exists()


@pytest.mark.parametrize("key", [key for key, _, _ in NEEDED])
def test_each_key_that_lacks_is_named_and_what_the_list_says_to_write_is_taken(small: Path, key: str) -> None:
    stated = json.loads(json.dumps(STATED))
    put(stated, key, [] if isinstance(value_of(stated, key), list) else "  ")
    if key in ("issued", "received", "performed") or key.endswith("country"):
        stated = without(stated, key)
    state(small, None)
    write(small, stated)
    with pytest.raises(PlanError) as refused:
        ic.certificate(small, small / "c.xml")
    (problem,) = refused.value.problems
    table, _, line = problem.do.removeprefix("Write in [").partition("]: ")
    name = key.rpartition(".")[2]
    assert line.startswith(f"{name} = ")
    assert table == ".".join(filter(None, ("certificate", key.rpartition(".")[0])))
    import tomllib

    put(stated, key, tomllib.loads(line)[name])
    write(small, stated)
    assert ic.certificate(small, small / "c.xml").number


def value_of(stated: dict[str, Any], key: str) -> Any:
    table, _, name = key.rpartition(".")
    return (stated[table] if table else stated)[name]


def without(stated: dict[str, Any], key: str) -> dict[str, Any]:
    table, _, name = key.rpartition(".")
    del (stated[table] if table else stated)[name]
    return stated


def write(folder: Path, stated: dict[str, Any]) -> None:
    from inertialcal.core.campaign_text import toml_text

    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8").partition("\n[certificate]")[0]
    path.write_text(text + toml_text({"certificate": stated}), encoding="utf-8")


def test_a_campaign_without_the_name_of_its_item_is_refused(small: Path) -> None:
    for name, _, _ in OF_ITEM:
        text = (small / "campaign.toml").read_text(encoding="utf-8")
        lines = [line for line in text.splitlines() if not line.startswith(f"{name} = ")]
        (small / "campaign.toml").write_text("\n".join(lines), encoding="utf-8")
        with pytest.raises(PlanError, match=f"{name} = "):
            ic.certificate(small, small / "c.xml")
        (small / "campaign.toml").write_text(text, encoding="utf-8")


@pytest.mark.parametrize(
    "changes",
    [{"issued": "2026-11-19"}, {"received": "2026-11-04"}, {"performed": ["2026-11-20", "2026-11-03"]},
     {"issued": "28 November"}],
)  # fmt: skip
def test_days_out_of_order_are_refused(small: Path, changes: dict[str, Any]) -> None:
    assert code_of(lambda: ic.certificate(state(small, changes), small / "c.xml")) == "wrong_value"


# What it could lie about


def test_a_certificate_needs_no_run_after_its_table_was_written(small: Path) -> None:
    state(small, {"number": "2026-015"})
    assert ic.certificate(small, small / "c.xml").number == "2026-015"


def test_results_older_than_the_campaign_are_refused(small: Path) -> None:
    replace(small, 'limit = "5 %"', 'limit = "50 %"')
    assert code_of(lambda: ic.certificate(small, small / "c.xml")) == "old_results"
    run(small)
    ic.certificate(small, small / "c.xml")


def test_results_of_other_recordings_are_refused(small: Path) -> None:
    with (small / "one.csv").open("a", encoding="utf-8") as file:
        file.write("4.0,4.05,0.004,2,7\n")
    assert code_of(lambda: ic.certificate(small, small / "c.xml")) == "old_results"
    (small / "one.csv").unlink()
    assert code_of(lambda: ic.certificate(small, small / "c.xml")) == "missing_file"  # as check says it


def test_edited_results_are_refused(small: Path) -> None:
    place = small / "out" / "results.json"
    content = json.loads(place.read_text(encoding="utf-8"))
    for row in content["results"]:
        row["u"] = None if row["u"] is None else row["u"] / 10.0
    place.write_text(json.dumps(content), encoding="utf-8")
    assert code_of(lambda: ic.certificate(small, small / "c.xml")) == "checksum"
    del content["checksum"]
    place.write_text(json.dumps(content | {"checksum": checksum(content)}), encoding="utf-8")
    assert code_of(lambda: ic.certificate(small, small / "c.xml")) == "edited_results"


def resealed(folder: Path, name: str, content: dict[str, Any]) -> None:
    """Write a file of a run with its checksum and its line of SHA256SUMS, as somebody would who means it."""
    place, sums = folder / "out" / name, folder / "out" / "SHA256SUMS"
    old = hashlib.sha256(place.read_bytes()).hexdigest()
    if "checksum" in content:
        del content["checksum"]
        content |= {"checksum": checksum(content)}
    data = json.dumps(content).encode()
    place.write_bytes(data)
    text = sums.read_text(encoding="utf-8")
    assert old in text
    sums.write_text(text.replace(old, hashlib.sha256(data).hexdigest()), encoding="utf-8")


def test_a_model_that_is_not_of_the_results_is_refused(small: Path) -> None:
    content = json.loads((small / "out" / "results.json").read_text(encoding="utf-8"))
    rows = [row for row in content["results"] if row["test"] == "model" and row["value"]]
    assert rows
    rows[0]["value"] += rows[0]["u"]
    resealed(small, "results.json", content)
    with pytest.raises(DataError, match="the model is not of these results"):
        ic.certificate(small, small / "c.xml")


def test_a_model_that_readings_held_out_refuted_is_not_certified_and_that_is_said(small: Path) -> None:
    content = json.loads((small / "out" / "results.json").read_text(encoding="utf-8"))
    content["closed_loop"]["verdict"] = "FAIL"
    resealed(small, "results.json", content)
    (small / "out" / "model.json").unlink()
    ic.certificate(small, small / "c.xml")
    read = ic.read_certificate(small / "c.xml")
    assert "closed loop FAILs" in read.statements["Closed loop"]
    assert [one.name for one in read.figures] == ["first"]  # those of the test remain


def test_results_of_another_version_are_refused(small: Path) -> None:
    content = json.loads((small / "out" / "provenance.json").read_text(encoding="utf-8"))
    content["versions"]["inertialcal"] = "0.0.9"
    resealed(small, "provenance.json", content)
    with pytest.raises(DataError, match=r"made by version 0\.0\.9"):
        ic.certificate(small, small / "c.xml")


def test_a_campaign_that_was_not_run_is_refused(small: Path) -> None:
    shutil.rmtree(small / "out")
    assert code_of(lambda: ic.certificate(small, small / "c.xml")) == "no_results"


def test_days_that_a_recording_contradicts_are_refused(small: Path) -> None:
    replace(small, 'procedure = "rate_table"\n', 'procedure = "rate_table"\nday = "2026-10-30"\n')
    run(small)
    assert code_of(lambda: ic.certificate(small, small / "c.xml")) == "wrong_period"


# Standards


def results_of(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "out" / "results.json").read_text(encoding="utf-8"))
    return content


def test_without_a_valid_certificate_of_each_standard_it_is_not_traceable(small: Path) -> None:
    """What is not stated in this campaign, the latitude, is named too."""
    made_ = ic.certificate(small, small / "c.xml")
    assert not made_.traceable
    lacking = [one["standard"] for one in results_of(small)["standards"] if not one["stated"]]
    assert lacking
    for standard in lacking:
        assert [one for one in made_.warnings if one.startswith(f"{standard}.") and "not stated, and not in" in one]
    assert not [one for one in made_.warnings if "rate_table.rate:" in one]
    assert "not traceable" in ic.read_certificate(small / "c.xml").statements["Traceability"]


@pytest.mark.parametrize(
    ("valid", "why"),
    [
        ('certificate = "C-1", valid = "2025-01-01 to 2026-11-19"', "had ended on 2026-11-19"),
        ('certificate = "C-1", valid = "2026-11-04 to 2027-11-04"', "begins on 2026-11-04"),
        ('certificate = "C-1", valid = "until spring"', "not given in days"),
        ('certificate = "C-1"', "is not stated"),
        ('certificate = ""', "no certificate is stated"),
        ('certificate = "simulated"', "it is simulated"),
    ],
)
def test_a_standard_that_is_not_traceable_is_named_with_the_reason(small: Path, valid: str, why: str) -> None:
    replace(small, VALID[1], valid)
    run(small)
    found = ic.certificate(small, small / "c.xml")
    assert not found.traceable
    assert [one for one in found.warnings if one.startswith("rate_table.rate: not traceable") and why in one]
    said = ic.read_certificate(small / "c.xml").statements["Traceability of rate_table.rate"]
    assert "not traceable" in said
    assert why in said


def test_without_any_standard_it_is_not_traceable(tmp_path: Path) -> None:
    folder = made("reinel1969", tmp_path / "c")
    assert results_of(folder)["standards"] == []
    found = ic.certificate(folder, folder / "c.xml")
    assert not found.traceable
    assert found.warnings == ("not traceable: no standard is stated",)
    assert "Traceability" in ic.read_certificate(folder / "c.xml").statements


def test_with_all_standards_certified_it_is_traceable(small: Path) -> None:
    (before,) = [one for one in content_of(small).standards if one.name == "rate_table.rate"]
    assert before.traceable
    others = [one.name for one in content_of(small).standards if not one.traceable]
    assert others
    stated = VALID[1].replace(", ", "\n")
    added = "".join(f'[standards.{name}]\nu = "{u_of(name)}"\n{stated}\n' for name in others)
    replace(small, "[sensors.suite]", added + "[sensors.suite]")
    run(small)
    found = ic.certificate(small, small / "c.xml")
    assert found.traceable, found.warnings
    root = xml_root((small / "c.xml").read_bytes())
    assert {one.text for one in root.iterfind(".//dcc:traceable", NAMESPACES)} == {"true"}


def u_of(name: str) -> str:
    from inertialcal.core.schema.standards import STANDARDS

    standard, _, quantity = name.partition(".")
    unit = STANDARDS[standard][quantity]
    return "0.01 %" if unit == "1" else f"0.001 {unit}"


@pytest.mark.parametrize(
    ("valid", "wanted"),
    [
        ("2026-01-01 to 2027-01-01", (date(2026, 1, 1), date(2027, 1, 1))),
        ("until 2026-06", (date.min, date(2026, 6, 30))),
        ("2024", (date.min, date(2024, 12, 31))),
        ("2024-02 to 2024", (date(2024, 2, 1), date(2024, 12, 31))),
        ("2026-02-30", None),
        ("2026-13", None),
        ("three days: 2024, 2025, 2026", None),
        ("", None),
    ],
)
def test_periods_are_read(valid: str, wanted: object) -> None:
    assert period_of(valid) == wanted


def test_the_standard_of_laboratories_is_never_claimed(small: Path) -> None:
    ic.certificate(small, small / "c.xml")
    assert "17025" not in (small / "c.xml").read_text(encoding="utf-8")


def test_simulated_data_are_named_in_the_head(small: Path) -> None:
    (small / ".truth").mkdir()
    (small / ".truth" / "truth.json").write_text("{}", encoding="utf-8")
    assert not ic.certificate(small, small / "c.xml").traceable
    assert "no item was calibrated" in ic.read_certificate(small / "c.xml").statements["Simulated data"]


def test_the_table_changes_no_digest_and_any_other_key_does(small: Path) -> None:
    before = load(small).digest()
    state(small, {"number": "7"})
    assert load(small).digest() == before
    replace(small, 'serial = "7"', 'serial = "8"')
    assert load(small).digest() != before


# The suite in air and in vacuum


@pytest.mark.slow
def test_the_demo_is_certified_as_it_is_each_condition_with_its_own_figures(tmp_path: Path, shared: Path) -> None:
    twin = short_twin(1)
    (tmp_path / "recordings").mkdir()
    (tmp_path / "campaign.toml").write_text(twin.campaign.replace(SEED, "1"), encoding="utf-8")
    for file, recording in twin.recordings.items():
        (tmp_path / file).write_text(csv_text(recording), encoding="utf-8")
    run(tmp_path)
    target = tmp_path / "c.xml"
    ic.certificate(tmp_path, target)
    schemas = compiled(shared, tmp_path)
    assert schemas.problems(target.read_bytes()) == []
    assert schemas.errors(target) == []
    read = {one.name: one for one in ic.read_certificate(target).figures}
    bias = {}
    for name, condition in (("model", "air"), ("model_vacuum", "vacuum")):
        estimate = ic.load_model(tmp_path, condition).estimate
        assert estimate is not None
        at = estimate.names.index("bias_x")
        bias[condition] = read[name].values[read[name].labels.index("bias_x")]
        assert bias[condition] == pytest.approx(np.degrees(estimate.values[at]), rel=1e-12)
        np.testing.assert_allclose(
            read[name].u[read[name].labels.index("bias_x")], np.degrees(estimate.u[at]), rtol=1e-12
        )
    assert bias["air"] != bias["vacuum"]


# The page

HOSTILE = '#eval("1") $x$ @a \\ [b] *c* `d` <e> // f \u202eg\u202c // \'"'


@pytest.fixture
def pdf() -> Any:
    pytest.importorskip("typst")
    return pytest.importorskip("pikepdf")


def test_the_page_is_the_same_twice_archivable_and_holds_its_xml(small: Path, pdf: Any) -> None:
    import io

    ic.certificate(small, small / "c.pdf")
    data = (small / "c.pdf").read_bytes()
    ic.certificate(small, small / "c.pdf")
    assert (small / "c.pdf").read_bytes() == data
    ic.certificate(small, small / "c.xml")
    with pdf.open(io.BytesIO(data)) as found:
        assert 1 <= len(found.pages) <= 2
        with found.open_metadata() as described:
            assert (described["pdfaid:part"], described["pdfaid:conformance"]) == ("3", "B")
        assert str(found.Root.OutputIntents[0].S) == "/GTS_PDFA1"
        (attached,) = found.attachments.values()
        assert attached.get_file().read_bytes() == (small / "c.xml").read_bytes()
        assert str(found.Root.AF[0].AFRelationship) == "/Alternative"
        fonts = [one for page in found.pages for _, one in page.Resources.get("/Font", {}).items()]
        assert fonts
        for font in fonts:
            for one in font.get("/DescendantFonts", [font]):
                assert any(name in one.FontDescriptor for name in ("/FontFile", "/FontFile2", "/FontFile3"))


def text_of(path: Path, need: Callable[[str], str]) -> str:
    import subprocess

    done = subprocess.run([need("pdftotext"), "-layout", str(path), "-"], capture_output=True, check=True)
    return done.stdout.decode("utf-8")


@pytest.mark.usefixtures("pdf")
def test_the_page_says_what_the_standard_lists(small: Path, need: Callable[[str], str]) -> None:
    ic.certificate(small, small / "c.pdf")
    said = " ".join(text_of(small / "c.pdf", need).split())
    for words in ("Calibration certificate", "No. 2026-014", "page 1 of 2", "page 2 of 2", "Inertial Laboratory",
                  "Small Satellite Office", "no visible damage", "2026-11-03 to 2026-11-20", "IEEE Std 1431-2004",
                  "(23 +- 1) degC", "relate only to the items", "except in full", "Decision rule", "A. Person",
                  "head of laboratory", "End of certificate", "not traceable", "C-1"):  # fmt: skip
        assert words in said, words


@pytest.mark.usefixtures("pdf")
def test_text_of_others_is_shown_as_it_is(small: Path, need: Callable[[str], str]) -> None:
    hostile = {"item_condition": HOSTILE, "methods": [HOSTILE], "number": HOSTILE,
               "laboratory": {"name": HOSTILE, "city": HOSTILE, "country": "US"}}  # fmt: skip
    ic.certificate(state(small, hostile), small / "c.pdf")
    said = " ".join(text_of(small / "c.pdf", need).split())
    shown = HOSTILE.replace("\u202e", "\ufffd").replace("\u202c", "\ufffd")
    assert " ".join(shown.split()) in said
    assert "\u202e" not in said


@pytest.mark.usefixtures("pdf")
def test_what_typst_says_is_said(small: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from inertialcal.campaign.certificate import page

    monkeypatch.setattr(page, "XML_NAME", "no/such\x00file.xml")
    monkeypatch.setattr(page, "_data", lambda content: {"title": 3})
    with pytest.raises(InertialcalError, match="typst made no PDF: ") as refused:
        ic.certificate(small, small / "c.pdf")
    assert refused.value.problems[0].code == "not_typeset"
    assert not (small / "c.pdf").exists()


@pytest.mark.parametrize(("module", "extra", "name"), [("typst", "pdf", "c.pdf"), ("signxml", "sign", "c.xml")])
def test_an_extra_that_is_missing_is_named_with_what_to_type(
    small: Path, monkeypatch: pytest.MonkeyPatch, module: str, extra: str, name: str
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, module, None)
    key = small / "campaign.toml" if extra == "sign" else None
    with pytest.raises(UsageError, match=rf"pip install 'inertialcal\[{extra}\]'"):
        ic.certificate(small, small / name, key, key)


@pytest.mark.parametrize("name", ["c.txt", "c", "c.pdf.html"])
def test_another_ending_is_refused(small: Path, name: str) -> None:
    assert code_of(lambda: ic.certificate(small, small / name)) == "unsupported_format"


def test_the_command_says_what_it_wrote(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = small / "c.xml"
    for words in ([], ["--json"], ["--quiet"]):
        with pytest.raises(SystemExit) as ended:
            main(["certificate", str(small), "-o", str(target), *words])
        assert ended.value.code in (0, None)
        out = capsys.readouterr().out
        if words == ["--json"]:
            said = json.loads(out)
            assert (said["command"], said["exit"], said["number"]) == ("certificate", 0, "2026-014")
            assert said["sha256"] == hashlib.sha256(target.read_bytes()).hexdigest()
            assert said["traceable"] is False
            assert said["warnings"]
        elif words:
            assert out == ""
        else:
            said = " ".join(out.split())  # a long path stands on a line of its own
            assert said.startswith("certificate 2026-014 written to ")
            assert "not traceable" in said


# Signature


@pytest.fixture(scope="module")
def signers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Keys and certificates of two signers."""
    pytest.importorskip("signxml")
    from datetime import UTC, datetime, timedelta

    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import rsa
    from cryptography.x509.oid import NameOID

    folder = tmp_path_factory.mktemp("signers")
    now = datetime.now(UTC)
    for who in ("laboratory", "other"):
        key = rsa.generate_private_key(public_exponent=65537, key_size=2048)
        name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, who)])
        builder = x509.CertificateBuilder().subject_name(name).issuer_name(name).public_key(key.public_key())
        builder = builder.serial_number(7).not_valid_before(now - timedelta(1)).not_valid_after(now + timedelta(9))
        public = builder.sign(key, hashes.SHA256()).public_bytes(serialization.Encoding.PEM)
        private = key.private_bytes(
            serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        )
        (folder / f"{who}.key").write_bytes(private)
        (folder / f"{who}.pem").write_bytes(public)
    return {path.name: path for path in folder.iterdir()}


@pytest.fixture
def signed(small: Path, signers: dict[str, Path]) -> Path:
    made_ = ic.certificate(small, small / "c.xml", signers["laboratory.key"], signers["laboratory.pem"])
    assert made_.signed
    return small / "c.xml"


def test_a_signed_certificate_is_verified_and_still_valid(
    signed: Path, signers: dict[str, Path], shared: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    assert ic.read_certificate(signed).signature == "signed, not verified"
    assert ic.read_certificate(signed, signers["laboratory.pem"]).signature == "verified"
    schemas: Schemas = compiled(shared, tmp_path_factory.mktemp("schemas"))
    assert schemas.problems(signed.read_bytes()) == []
    # The rules want no empty element; those of a signature are empty by its own standard
    assert {one.partition(".")[0] for one in schemas.errors(signed)} == {"Empty element"}


def test_what_was_changed_after_it_was_signed_is_refused(signed: Path, signers: dict[str, Path]) -> None:
    data = signed.read_bytes()
    changed = data.replace(b"<si:valueXMLList>", b"<si:valueXMLList>1", 1)
    assert changed != data
    signed.write_bytes(changed)
    assert code_of(lambda: ic.read_certificate(signed, signers["laboratory.pem"])) == "wrong_signature"
    ic.read_certificate(signed)  # it says that it was not verified


def test_another_signer_is_refused(signed: Path, signers: dict[str, Path]) -> None:
    assert code_of(lambda: ic.read_certificate(signed, signers["other.pem"])) == "wrong_signature"


def test_what_is_not_signed_is_not_verified(small: Path, signers: dict[str, Path]) -> None:
    ic.certificate(small, small / "c.xml")
    assert ic.read_certificate(small / "c.xml").signature == "not signed"
    assert code_of(lambda: ic.read_certificate(small / "c.xml", signers["laboratory.pem"])) == "not_signed"


def test_a_signed_part_does_not_vouch_for_the_whole(signed: Path, signers: dict[str, Path]) -> None:
    """The signed certificate, wrapped into another one that says something else."""
    inner = signed.read_bytes().partition(b"?>")[2]
    data = signed.read_bytes()
    head, _, rest = data.partition(b"<dcc:measurementResults>")
    forged = head.replace(b"2026-014", b"2026-666") + b"<dcc:measurementResults>" + rest
    comment = b"<dcc:comment>" + inner + b"</dcc:comment>"
    cut = forged.partition(b"<ds:Signature")[0]
    signed.write_bytes(cut + comment + b"</dcc:digitalCalibrationCertificate>")
    assert code_of(lambda: ic.read_certificate(signed, signers["laboratory.pem"])) == "wrong_signature"


def test_of_a_verified_certificate_only_what_is_signed_is_read(small: Path, signers: dict[str, Path]) -> None:
    """A part that was signed by its name, inside of another certificate: the other one is not what is read."""
    import signxml
    from lxml import etree

    ic.certificate(small, small / "c.xml")
    data = (small / "c.xml").read_bytes()
    inner = etree.fromstring(data)
    inner.set("Id", "part")
    key, public = (signers[f"laboratory.{one}"].read_bytes() for one in ("key", "pem"))
    part = signxml.signer.XMLSigner().sign(inner, key=key, cert=public.decode(), reference_uri="#part")
    outer = etree.fromstring(data.replace(b"2026-014", b"2026-666"))
    etree.SubElement(outer, "{https://ptb.de/dcc}comment").append(part)
    (small / "c.xml").write_bytes(etree.tostring(outer))
    assert ic.read_certificate(small / "c.xml").number == "2026-666"  # not verified, and so it says
    assert ic.read_certificate(small / "c.xml", signers["laboratory.pem"]).number == "2026-014"


def test_a_key_and_a_certificate_that_do_not_belong_together_are_refused(small: Path, signers: dict[str, Path]) -> None:
    mixed = (signers["laboratory.key"], signers["other.pem"])
    assert code_of(lambda: ic.certificate(small, small / "c.xml", *mixed)) == "wrong_key"
    text = (small / "campaign.toml", signers["laboratory.pem"])
    assert code_of(lambda: ic.certificate(small, small / "c.xml", *text)) == "wrong_key"
    assert code_of(lambda: ic.certificate(small, small / "c.xml", signers["laboratory.key"])) == "half_a_signature"
    assert not (small / "c.xml").exists()
