"""Statistics of a lot from its rows: truth recovered, what stands out, the page."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest

from inertialcal.core.show.tables import text
from inertialcal.lots.drawn import content_of_lot
from inertialcal.lots.page import lot_page
from inertialcal.lots.study import Columns, study
from inertialcal.lots.table import JUDGED, Figure, Limits, Table, Wrong
from inertialcal.statistics.population.scatter import Population

U_RATE = 0.03  # of a station's table [%]
OWN = {"scale_factor_error": 0.02, "bias": 0.004, "noise": 0.01}
SCATTER = {"scale_factor_error": 0.2, "bias": 0.03, "noise": 0.03}
MEAN = {"scale_factor_error": 0.1, "bias": 0.01, "noise": 0.3}
LIMIT = {"scale_factor_error": (-0.8, 0.8), "bias": (-0.1, 0.1), "noise": (None, 0.4)}
UNIT = {"scale_factor_error": "%", "bias": "deg/s", "noise": "deg/sqrt(h)"}
LINE = Columns("station", "tested", ("position",))


def lot(
    n: int,
    seed: int,
    bad_station: float = 0.0,
    odd: int = 0,
    drift: float = 0.0,
    repeated: int = 0,
    stated: float = 1.0,
) -> Table:
    """Return a lot, drawn here: three figures, four stations; of some units every station makes two tests."""
    rng = np.random.default_rng(seed)
    units, stations = [], []
    for k in range(n):
        several = k < repeated
        units += [k] * (8 if several else 1)
        stations += [s for s in range(4) for _ in range(2)] if several else [k % 4]
    unit, station = np.array(units), np.array(stations)
    rows, names = unit.size, list(MEAN)
    error = U_RATE * rng.standard_normal(4)
    error[2] += bad_station
    columns = []
    for name in names:
        true = MEAN[name] + SCATTER[name] * rng.standard_normal(n)
        true[n - odd :] += 10.0 * SCATTER[name]
        if name == "scale_factor_error":
            true += drift * (np.arange(n) / n - 0.5)
        y = true[unit] + OWN[name] * rng.standard_normal(rows)
        columns.append(y + error[station] if name == "scale_factor_error" else y)
    values = np.column_stack(columns)
    common = np.zeros(values.shape)
    common[:, 0] = U_RATE
    u = np.sqrt((stated * np.array(list(OWN.values()))) ** 2 + common**2)
    limits = {}
    for k, name in enumerate(names):
        low, high = LIMIT[name]
        inside = (values[:, k] > (-np.inf if low is None else low)) & (
            values[:, k] < (np.inf if high is None else high)
        )
        limits[k] = (Limits(f"R{k}", low, high, np.where(inside, 0, 1).astype(np.int8)),)
    good = np.all([each[0].verdicts == 0 for each in limits.values()], axis=0)
    cells = pa.table({
        "station": [f"S{s}" for s in station], "position": [int(i % 6) for i in range(rows)],
        "tested": [f"2026-11-{1 + i * 27 // rows:02d}T{i % 24:02d}:00:00Z" for i in range(rows)],
    })  # fmt: skip
    figures = tuple(Figure("test", name, "x", "", 0, "", None, "", "", UNIT[name]) for name in names)
    return Table(
        tuple(f"U{k:04d}" for k in units), ("done",) * rows, tuple(JUDGED[0 if one else 1] for one in good),
        ("",) * rows, figures, values, u, np.full(values.shape, np.inf), common, limits, {}, cells,
    )  # fmt: skip


def held(population: Population, scatter: float) -> bool:
    low, high = population.scatter_interval.lo, population.scatter_interval.hi
    return low is not None and high is not None and low < scatter < high


def test_the_population_is_recovered() -> None:
    found = study(lot(400, 1), LINE)
    for one in found.figures:
        name, population = one.figure.quantity, one.found
        assert population is not None
        assert held(population, SCATTER[name])
        assert abs(population.mean - MEAN[name]) < 3.0 * population.mean_u
    assert not found.off
    assert not found.odd
    assert not found.drifting


def test_what_a_station_shares_is_no_scatter_of_units() -> None:
    """The mean of a lot at four stations is known no better than half the error of a table."""
    population = study(lot(4000, 2), LINE).figures[0].found
    assert population is not None
    assert population.mean_u == pytest.approx(U_RATE / 2.0, rel=0.15)


def test_a_bad_station_is_named_and_left_out() -> None:
    found = study(lot(400, 3, bad_station=0.5), LINE)
    assert [(one.column, one.level, one.figure.quantity) for one in found.off] == [
        ("station", "S2", "scale_factor_error")
    ]
    population = found.figures[0].found
    assert population is not None
    assert population.n == 300
    assert abs(population.mean - MEAN["scale_factor_error"]) < 3.0 * population.mean_u
    assert "station S2" in text(found.parts())


@pytest.mark.parametrize("seed", range(3))
def test_a_drift_hides_no_station_and_makes_none(seed: int) -> None:
    """A drift three times as large as the units scatter; in the second lot stations tested one after the other."""
    found = study(lot(80, seed, bad_station=0.35, drift=0.7), LINE)
    assert {one.level for one in found.off} == {"S2"}
    table, late = lot(200, seed), np.arange(200) / 200
    columns = table.columns.set_column(0, "station", pa.array([f"S{int(4.0 * one)}" for one in late]))
    told = 0.2 * np.random.default_rng(seed).standard_normal(table.told.shape) + 0.7 * late[:, None]
    found = study(replace(table, told=told, columns=columns), LINE)
    assert not found.off


def test_odd_units_are_named_and_in_no_capability() -> None:
    found = study(lot(400, 4, odd=4), LINE)
    assert [one.serial for one in found.odd] == [f"U{k:04d}" for k in range(396, 400)]
    population = found.figures[1].found
    assert population is not None
    assert population.scatter == pytest.approx(SCATTER["bias"], rel=0.12)
    assert found.passed.of == 400


def test_tests_with_errors_are_named_and_in_no_population() -> None:
    """Dwells in rad/s, axes that are exchanged: few units scatter by what is no scatter of theirs."""
    drawn = lot(24, 4)
    told = drawn.told.copy()
    told[[3, 7]] = 0.017 * told[[3, 7]] - 98.0
    wrong = (
        Wrong(3, "test", "unit_disagrees", "x reads +0.017 of the rate", 2),
        Wrong(7, "", "disturbed", "it was", 1),
    )
    found = study(Table(**{**vars(drawn), "told": told, "wrong": wrong}), LINE)
    population = found.figures[0].found
    assert population is not None
    assert population.scatter < 0.4
    assert "unit U0003: test: x reads +0.017 of the rate (and 1 more)" in text(found.parts())
    assert [(one["serial"], one["code"]) for one in found.content()["wrong_tests"]] == [
        ("U0003", "unit_disagrees"),
        ("U0007", "disturbed"),
    ]
    page = lot_page(found, "wrong")
    assert "test unit disagrees" in page
    assert "unit U0007: it was" in page


@pytest.mark.parametrize("form", ["{0:02d}.03.2026 08:00", "{0}.3.2026", "2026-03-{0:02d}T08:00:00", "heute"])
def test_days_are_read_as_they_are_written_or_it_is_said(form: str) -> None:
    drawn = lot(400, 5, drift=0.6)
    days = pa.array([form.format(1 + i * 27 // len(drawn)) for i in range(len(drawn))])
    columns = drawn.columns.set_column(drawn.columns.column_names.index("tested"), "tested", days)
    found = study(Table(**{**vars(drawn), "columns": columns}), LINE)
    said = {one.code for one in found.remarks}
    assert bool(found.drifting) is (form != "heute")
    assert ("no_place" in said) is (form == "heute")


def test_a_drift_is_named() -> None:
    found = study(lot(400, 5, drift=0.6), LINE)
    assert [one.figure.quantity for one in found.drifting] == ["scale_factor_error"]


@pytest.mark.parametrize(("stated", "code"), [(1.0, ""), (0.3, "understated"), (4.0, "overstated")])
def test_repeats_tell_what_the_tests_scatter(stated: float, code: str) -> None:
    found = study(lot(200, 6, repeated=15, stated=stated), LINE)
    codes = {one.code for one in found.remarks}
    assert codes & {"understated", "overstated"} == ({code} if code else set())
    tested = found.figures[1].gauge
    assert tested is not None
    assert tested.repeatability.value == pytest.approx(OWN["bias"], rel=0.2)
    population = found.figures[1].found
    assert population is not None
    assert held(population, SCATTER["bias"])


def test_a_unit_counts_once() -> None:
    found = study(lot(100, 7, repeated=10), LINE)
    assert found.passed.of == 100
    assert all(one.n == 100 for one in found.figures)


@pytest.mark.parametrize("n", [1, 2, 3, 7])
def test_few_units(n: int) -> None:
    found = study(lot(n, 8), LINE)
    assert "few_units" in {one.code for one in found.remarks}
    assert json.loads(json.dumps(found.content(), allow_nan=False))["units"] == n
    assert "Report of a lot" in lot_page(found, "few")


def test_without_columns_of_the_line() -> None:
    found = study(lot(60, 9), Columns())
    assert not found.off
    assert found.figures[0].along is not None


def test_content_is_json_and_frame_has_a_row_a_figure() -> None:
    found = study(lot(100, 10, odd=1), LINE)
    assert json.dumps(found.content(), allow_nan=False)
    pytest.importorskip("pandas")
    assert len(found.to_frame()) == 3


def test_every_kind_of_figure_is_drawn() -> None:
    names = {one["name"] for one in content_of_lot(study(lot(200, 11, bad_station=0.5), LINE))["curves"]}
    assert names == {"lot_distribution", "lot_population", "lot_stations", "lot_along", "lot_distance"}


def test_the_page_holds_every_unit_and_no_markup_of_the_users() -> None:
    table = lot(40, 12)
    evil = ("</script><script>alert(1)</script>", *table.serials[1:])
    page = lot_page(study(Table(**{**vars(table), "serials": evil}), LINE), "<b>lot</b>", "a & b")
    assert "<b>lot</b>" not in page
    assert "alert(1)</script>" not in page
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)[1])  # type: ignore[index]
    assert len(data["units"]) == 40
    assert data["units"][0]["serial"] == evil[0]
    assert not re.search(r"(src|href)=[\"']?(?!#)[a-z/.]", page)
