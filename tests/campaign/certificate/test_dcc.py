"""The XML of a certificate: valid by the schema and rules of its makers, read back to the last digit."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from certified import CAMPAIGNS, NAMESPACES, Schemas, compiled, made, state
from hypothesis import given, settings
from hypothesis import strategies as st

import inertialcal as ic
from inertialcal.campaign.certificate.content import Content, Figures, content_of
from inertialcal.campaign.certificate.dcc import dcc_xml
from inertialcal.core.errors import DataError
from inertialcal.core.units import factor
from inertialcal.files.xml_text import xml_root

pytestmark = pytest.mark.usefixtures("undrawn")


@pytest.fixture(scope="module")
def schemas(shared: Path, tmp_path_factory: pytest.TempPathFactory) -> Schemas:
    return compiled(shared, tmp_path_factory.mktemp("schemas"))


MADE: dict[str, Path] = {}  # each campaign is run once


@pytest.fixture(params=CAMPAIGNS)
def folder(request: pytest.FixtureRequest, tmp_path: Path, campaign: Callable[..., Path]) -> Path:
    if request.param not in MADE:
        MADE[request.param] = made(request.param, tmp_path / "c", campaign)
    return MADE[request.param]


def test_the_xml_of_each_campaign_is_valid(folder: Path, schemas: Schemas) -> None:
    target = folder / "c.xml"
    ic.certificate(folder, target)
    assert schemas.problems(target.read_bytes()) == []
    assert schemas.errors(target) == []
    units = [
        (one.text or "").split() for one in xml_root(target.read_bytes()).iterfind(".//si:unitXMLList", NAMESPACES)
    ]
    several = [one for one in units if len(one) > 1]  # of figures with a covariance, which need one list
    assert all(len(set(one)) > 1 for one in several)
    warnings = schemas.errors(target, "warning")
    assert len(warnings) == len(several)
    assert all("one list element for a dataset which contain data with differing units" in one for one in warnings)


def test_of_each_campaign_all_figures_read_back_to_the_last_digit(folder: Path) -> None:
    content = content_of(folder)
    target = folder / "c.xml"
    assert ic.certificate(folder, target).figures == sum(len(one.labels) for one in content.figures) > 0
    first = target.read_bytes()
    ic.certificate(folder, target)
    assert target.read_bytes() == first
    read = ic.read_certificate(target)
    assert [one.labels for one in read.figures] == [one.labels for one in content.figures]
    rows = json.loads((folder / "out" / "results.json").read_text(encoding="utf-8"))["results"]
    for one, wanted in zip(read.figures, content.figures, strict=True):
        assert one.units == wanted.units
        np.testing.assert_array_equal(one.values, wanted.values)
        if one.covariance is None:
            assert wanted.covariance is None
        else:
            np.testing.assert_array_equal(one.covariance, wanted.covariance)
            np.testing.assert_allclose(np.sqrt(np.diag(one.covariance)), one.u, rtol=1e-6)
        if one.expanded is not None:
            np.testing.assert_array_equal(one.expanded, wanted.expanded)
            np.testing.assert_array_equal(one.k, wanted.k)
        # Each figure is one of results.json, in its unit or in SI
        for value, u, unit in zip(one.values, one.u, one.units, strict=True):
            assert any(same(row, value, u, unit) for row in rows)


def same(row: dict[str, Any], value: float, u: float, unit: str) -> bool:
    if row["value"] is None or row["u"] is None:
        return False
    try:
        scale = factor(row["unit"], unit, difference=True)
    except DataError:
        return False
    wanted = np.array([row["value"] * scale, row["u"] * scale])
    return bool(np.isclose(wanted, [value, u], rtol=1e-12, atol=0.0).all())


def test_the_schema_and_the_rules_refuse_what_is_wrong(
    schemas: Schemas, tmp_path: Path, campaign: Callable[..., Path]
) -> None:
    """They would see it: no check that cannot fail."""
    data = dcc_xml(content_of(made("small", tmp_path, campaign)))
    assert schemas.problems(data.replace(b"2026-11-28", b"28.11.2026"))
    broken = tmp_path / "broken.xml"
    broken.write_bytes(data.replace(f">v{ic.__version__}<".encode(), b">newest<"))
    assert any("release" in one for one in schemas.errors(broken))


# Numbers of any size

numbers = st.floats(-1e300, 1e300, allow_subnormal=True)
sizes = st.floats(5e-324, 1e150)


def figures(values: list[float], u: list[float], k: list[float], matrix: np.ndarray) -> Figures:
    n = len(values)
    labels = tuple(f"bias_{i}" for i in range(n))
    value, size, factors = np.array(values), np.array(u), np.array(k)
    half = factors * size
    units = ("deg/s", "%", "count/s/(m/s^2)", "deg/sqrt(h)")[:n]
    return Figures("model", "", "gyro", labels, labels, units, value, size, factors, value - half, value + half, matrix)


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Content:
    return content_of(made("reinel1969", tmp_path_factory.mktemp("plain") / "c"))


@settings(max_examples=60)
@given(data=st.data())
def test_any_number_comes_back(plain: Content, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    n = data.draw(st.integers(1, 4))

    def each(size: st.SearchStrategy[float]) -> list[float]:
        return data.draw(st.lists(size, min_size=n, max_size=n))

    entries = data.draw(st.lists(numbers, min_size=n * n, max_size=n * n))
    one = figures(
        each(numbers), each(sizes),
        each(st.floats(1.0, 1e30)), np.array(entries).reshape(n, n),
    )  # fmt: skip
    target = tmp_path_factory.mktemp("any") / "c.xml"
    target.write_bytes(dcc_xml(replace(plain, figures=(one,))))
    (read,) = ic.read_certificate(target).figures
    np.testing.assert_array_equal(read.values, one.values)
    np.testing.assert_array_equal(read.covariance, one.covariance)
    assert read.units == one.units
    if one.is_symmetric:
        np.testing.assert_array_equal(read.expanded, one.expanded)
        np.testing.assert_array_equal(read.k, one.k)


# Files of others


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        (rb"<dcc:digital", b'<!DOCTYPE a [<!ENTITY e "x">]><dcc:digital', "document type"),
        (rb"3\.3\.0", b"3.2.0", "version"),
        (rb"(<si:valueXMLList>)\S+", rb"\1NaN", "finite"),
        (rb"(<si:valueXMLList>)\S+ ", rb"\1", "numbers, need"),
        (rb"(<si:unitXMLList>)\S+", rb"\1\\candela", "differ"),
        (rb"</dcc:admin", b"<", "not XML"),
    ],
)  # fmt: skip
def test_what_is_no_certificate_is_refused(plain: Content, tmp_path: Path, old: bytes, new: bytes, why: str) -> None:
    data = dcc_xml(plain).replace(b"?>\n", b"?>", 1)
    target = tmp_path / "c.xml"
    broken = re.sub(old, new, data, count=1)
    assert broken != data
    target.write_bytes(broken)
    with pytest.raises(DataError, match=why) as refused:
        ic.read_certificate(target)
    assert refused.value.problems[0].code == "no_certificate"


@pytest.mark.parametrize("folder", ["npsat2011"], indirect=True)
def test_a_verdict_that_is_inconclusive_is_no_pass(folder: Path) -> None:
    root = xml_root(dcc_xml(content_of(folder)))
    statements = root.findall(".//dcc:statement", NAMESPACES)
    said = {
        one.findtext("dcc:declaration/dcc:content", "", NAMESPACES): one.findtext("dcc:conformity", "", NAMESPACES)
        for one in statements
        if one.findtext("dcc:name/dcc:content", "", NAMESPACES).startswith("Requirement")
    }
    without = {"conditionalPass", "conditionalFail", ""}  # the last where nothing was found
    wanted = {"PASS": {"pass"}, "FAIL": {"fail"}, "INCONCLUSIVE": without, "OPEN": {""}}
    assert said
    for words, conformity in said.items():
        verdict = re.search(": (PASS|FAIL|INCONCLUSIVE|OPEN)", words)
        assert verdict is not None
        assert conformity in wanted[verdict[1]]


@pytest.mark.parametrize("folder", ["npsat2011"], indirect=True)
def test_entries_of_the_matrix_that_no_test_gave_are_not_stated(folder: Path) -> None:
    """The thesis turned each sensor about its own axis alone: its model has zeros there that nobody measured."""
    root = xml_root(dcc_xml(content_of(folder)))
    (matrix,) = root.findall(".//dcc:quantity[@refType='inertialcal_matrix']/si:realListXMLList", NAMESPACES)
    assert matrix.findtext("si:labelXMLList", "", NAMESPACES) == "M_xx M_yy M_zz"
    values = [float(one) for one in matrix.findtext("si:valueXMLList", "", NAMESPACES).split()]
    np.testing.assert_array_equal(values, np.diag(ic.load_model(folder).matrix[0]))


def test_a_name_with_markup_stays_text(tmp_path: Path, campaign: Callable[..., Path], schemas: Schemas) -> None:
    text = 'a</dcc:name>&lt;<!-- ]]> "\u202eb\x1b[31m  c '
    folder = state(made("small", tmp_path, campaign), {"item_condition": text, "number": "<&>", "methods": [text]})
    target = folder / "c.xml"
    ic.certificate(folder, target)
    assert schemas.problems(target.read_bytes()) == []
    assert schemas.errors(target) == []
    assert ic.read_certificate(target).number == "<&>"
    name = xml_root(target.read_bytes()).findtext(".//dcc:usedMethod/dcc:name/dcc:content", "", NAMESPACES)
    assert name == 'a</dcc:name>&lt;<!-- ]]> "\ufffdb\ufffd[31m c'
