"""plot takes what the package returns, gives axes, and never an empty figure."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import inertialcal as ic
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.recording import SECOND, Channel, Recording
from inertialcal.report.figures import figures
from inertialcal.sensors.catalogue import flight_unit
from inertialcal.sensors.model.assemble import model_from

TABLE = "rate [deg/s],gyro_x [deg/s],run\n" + "".join(
    f"{rate},{1.01 * rate + 0.02 + 0.001 * ((3 * run + rate) % 5)},{run}\n"
    for run in range(1, 6)
    for rate in (-40, -10, 10, 40)
)


@pytest.fixture
def found(tmp_path: Path) -> Any:
    (tmp_path / "x.csv").write_text(TABLE)
    return ic.rate_table(tmp_path / "x.csv", axis="x")


def recording(n: int = 2000) -> Recording:
    time = (np.arange(n) * 0.1 * SECOND).astype(np.int64)
    wave = Channel("gx", np.sin(np.arange(n) / 50.0), "deg/s", "header", "x", "gyro")
    counts = Channel("n", np.arange(n, dtype=np.int32))
    words = Channel("state", np.array(["on"] * n))
    return Recording((wave, counts, words), time, 0.1)


def estimate(*units: str) -> Estimate:
    k = len(units)
    scatter = Component("scatter", "A", np.eye(k) * 0.04, 5.0)
    return Estimate(tuple(f"v_{i}" for i in range(k)), np.arange(k, dtype=float), units, (scatter,))


def test_a_rate_table_is_reading_over_rate_in_the_unit_of_the_file(found: Any) -> None:
    above, below = ic.plot(found)
    assert (above.get_ylabel(), below.get_xlabel()) == ("reading [deg/s]", "applied [deg/s]")
    line = next(one for one in above.get_lines() if str(one.get_label()).startswith("dwells used"))
    np.testing.assert_allclose(sorted(set(line.get_xdata())), [-40.0, -10.0, 10.0, 40.0])
    assert "20 dwells within" in above.figure.get_suptitle()


def test_the_figure_is_chosen_by_name(found: Any) -> None:
    ax = ic.plot(found, figure="rate_error")
    assert ax.get_ylabel() == "error of a dwell mean [%]"
    assert ic.plot(found.result, figure="input_output")[1].get_xlabel() == "applied [rad/s]"


def test_a_spectrum_that_was_asked_for_is_drawn_as_one() -> None:
    still = np.random.default_rng(1).standard_normal(20_000)
    noise = {word: getattr(ic, word)(still, sample_rate=10.0, units="deg/s") for word in ("allan", "psd")}
    assert ic.plot(noise["psd"]).get_xlabel() == "frequency [Hz]"
    assert ic.plot(noise["psd"], figure="allan").get_xlabel() == ic.plot(noise["allan"]).get_xlabel()


def test_a_campaign_or_its_results_give_the_same_figure() -> None:
    curve = {
        "name": "compensated", "test": "model", "axis": "x",
        "columns": {
            "applied": {"unit": "deg/s", "values": [1.0, 2.0]}, "raw_error": {"unit": "deg/s", "values": [0.1, 0.2]},
            "compensated_error": {"unit": "deg/s", "values": [0.0, 0.01]}, "run": {"unit": "", "values": ["1", "1"]},
        },
    }  # fmt: skip
    content = {"curves": [curve]}
    for result in (content, SimpleNamespace(results=content)):
        ax = ic.plot(result)
        assert ax.get_ylabel() == "x error [deg/s]"
    with pytest.raises(DataError, match=r"no data for figure 'dwells'.*There are: compensated of model"):
        ic.plot(content, figure="dwells")
    with pytest.raises(DataError, match="no data for test 'two'"):
        ic.plot(content, test="two")
    assert ic.plot(content, axis="z") is not None  # a picture of all axes


def test_a_recording_is_a_panel_a_channel_and_texts_are_counted() -> None:
    axes = ic.plot(recording())
    assert [ax.get_title(loc="left") for ax in axes] == ["gx [deg/s]", "n [?]"]
    assert "2 of 3 channels" in axes[0].figure.get_suptitle()
    drawn = np.asarray(axes[0].get_lines()[0].get_ydata())
    assert len(drawn) <= 1200
    assert (np.nanmin(drawn), np.nanmax(drawn)) == (
        np.min(np.sin(np.arange(2000) / 50.0)),
        np.max(np.sin(np.arange(2000) / 50.0)),
    )
    assert ic.plot(recording(), axis="x").get_title(loc="left") == "gx [deg/s]"
    with pytest.raises(DataError, match=r"No channel of axis 'q'.*There are: x"):
        ic.plot(recording(), axis="q")


def test_a_recording_without_time_counts_samples() -> None:
    ax = ic.plot(Recording((Channel("a", np.array([1.0, 2.0, 4.0])),)))
    assert ax.get_xlabel() == "sample"
    assert np.asarray(ax.get_lines()[0].get_ydata())[::2].tolist() == [1.0, 2.0, 4.0]
    with pytest.raises(DataError, match="No channel with numbers"):
        ic.plot(Recording((Channel("a", np.array([np.nan])),)))
    with pytest.raises(DataError, match="No channel with numbers"):
        ic.plot(Recording(()))


def test_a_model_is_its_matrix() -> None:
    ax = ic.plot(flight_unit().models["corrected"])
    texts = {tuple(text.get_position()): text.get_text() for text in ax.texts}
    assert texts[0.5, 2.5].startswith("0.013")  # z reads 1.298 % of x: row z, column x
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("input axis", "sensor")
    with pytest.raises(UsageError, match=r"no figure 'dwells' of a SensorModel.*There is: matrix"):
        ic.plot(flight_unit().models["corrected"], figure="dwells")
    with pytest.raises(UsageError, match="has no test and no axis"):
        ic.plot(flight_unit().models["corrected"], test="one")


def test_a_model_shows_its_uncertainties_and_hatches_what_no_test_gave() -> None:
    names = tuple(f"{what}_{axis}" for what in ("bias", "scale_factor_error") for axis in "xyz")
    values = np.array([0.0, 0.0, 0.0, 0.01, -0.02, 0.005])
    scatter = Component("scatter", "A", np.diag(np.full(6, 1e-4) ** 2), 7.0)
    model = model_from(
        Estimate(names, values, ("rad/s",) * 3 + ("1",) * 3, (scatter,)), "gyro", ("x", "y", "z"), 1.0, "rad/s"
    )
    ax = ic.plot(model)
    texts = {tuple(text.get_position()): text.get_text() for text in ax.texts}
    assert texts[1.5, 1.5] == "−2.000\n± 0.010\n%"
    assert texts[0.5, 1.5] == "not\nestimated"


def test_an_estimate_is_a_panel_a_unit() -> None:
    axes = ic.plot(estimate("rad/s", "1", "rad/s"))
    assert [len(np.asarray(ax.get_lines()[-1].get_xdata())) for ax in axes] == [2, 1]
    assert axes[0].get_xlabel() == "value, 95 % interval [rad/s]"
    segments = axes[0].collections[0].get_segments()
    half = 0.2 * 2.5705818  # t, 97.5 %, 5 degrees of freedom
    np.testing.assert_allclose(segments[1][:, 0], [2.0 - half, 2.0 + half], rtol=1e-6)
    assert ic.plot(estimate("V")).figure.get_suptitle() == "v_0 = 0.00 ± 0.20 V"
    with pytest.raises(DataError, match="has no values"):
        ic.plot(estimate())


def test_axes_can_be_given_as_many_as_panels_or_one(found: Any) -> None:
    given = Figure().subplots(2, 1)
    drawn = ic.plot(found, ax=given)
    assert list(drawn) == list(given)
    assert given[0].get_title(loc="left").startswith("x: 20 dwells")
    whole = Figure().subplots()
    parts = ic.plot(found, ax=whole)
    assert [part.figure for part in parts] == [whole.figure] * 2
    assert not whole.axison
    with pytest.raises(UsageError, match=r"3 axes given, the figure 'input_output' has 2 panel\(s\)"):
        ic.plot(found, ax=Figure().subplots(3, 1))
    with pytest.raises(UsageError, match="Give 1 or 2 Axes"):
        ic.plot(found, ax=["not axes"])  # type: ignore[list-item]


def test_what_cannot_be_drawn_is_refused() -> None:
    for nothing in (None, 3, "results.json", {}, {"other": 1}):
        with pytest.raises(UsageError, match="cannot plot"):
            ic.plot(nothing)
    with pytest.raises(UsageError, match=f"There are: {', '.join(figures())}"):
        ic.plot({"curves": []}, figure="pie")
    with pytest.raises(DataError, match="no data to plot"):
        ic.plot({"curves": [], "results": []})


def test_the_users_own_settings_are_neither_used_nor_changed() -> None:
    import matplotlib as mpl

    with mpl.rc_context({"font.size": 31.0, "text.parse_math": True}):
        ax = ic.plot(recording())[0]
        ax.figure.draw_without_rendering()
        assert ax.get_yticklabels()[0].get_fontsize() == 9.0
        assert mpl.rcParams["font.size"] == 31.0


def test_a_script_has_no_pyplot_state_and_a_notebook_shows_the_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    import matplotlib as mpl
    from matplotlib import pyplot

    mpl.use("Agg")
    before = pyplot.get_fignums()
    ic.plot(recording())
    assert pyplot.get_fignums() == before
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=object, version_info=(9, 0)))
    ic.plot(recording())
    assert len(pyplot.get_fignums()) == len(before) + 1
    pyplot.close("all")
