"""Figures of vibration draw what calls on simulated records give."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from independent.case import csv_text
from independent.shaking.quadratic import Shaken, record
from independent.shaking.shaker import Mode, recorded
from independent.shaking.shaker import Run as Sweep
from independent.vibration.random_run import Run, simulate
from inertialcal.report.figures import figures, on_new_figure
from written_rows import fields

NODES = ((20.0, 0.01), (80.0, 0.04), (200.0, 0.04), (500.0, 0.01))  # g^2/Hz
RUN = Run(nodes=NODES, rate=1280.0, duration=10.0)
SWEEP = Sweep(50.0, 500.0, 10.0, sample_rate=2500.0, quiet=0.5)
CHANGED = {"test": "new", **fields(), "method": "change", "unit": "deg/s", "status": "estimated"}
CHANGES = [
    CHANGED | {"quantity": "bias", "axis": axis, "value": value, "u": 0.1, "dof": 8.0,
               "interval": {"lo": value - 0.2, "hi": value + 0.2, "p": 0.95}}
    for axis, value in (("x", 0.3), ("y", 1.4), ("z", -0.1))
]  # fmt: skip
JUDGED = [
    {"requirement": "R9", "quantity": "bias", "test": "new", "axis": axis, "sensor": "", "of": "change", "at": None,
     "at_unit": "", "unit": "deg/s", "lower": -1.0, "upper": 1.0, "verdict": word}
    for axis, word in (("x", "PASS"), ("y", "FAIL"))
]  # fmt: skip


def table(time_step: float, header: str, *columns: np.ndarray) -> str:
    rows = np.column_stack([np.arange(len(columns[0])) * time_step, *columns])
    return "\n".join([header, *(",".join(f"{value:.7g}" for value in row) for row in rows.tolist()), ""])


@cache
def vibration_curves() -> tuple[dict[str, Any], ...]:
    """Curves of every figure of vibration, of calls on records of a second or ten."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        profile, run, survey, effects = (
            folder / one for one in ("profile.csv", "run.csv", "survey.csv", "effects.csv")
        )
        nodes = "".join(f"{frequency},{level}\n" for frequency, level in NODES)
        profile.write_text(f"frequency [Hz],density [g2/Hz]\n{nodes}")
        control = simulate(RUN, 1)[0][:, 0]
        run.write_text(table(1.0 / RUN.rate, "t [s],control [m/s2],item [m/s2]", control, 1.1 * control))
        item = (Mode(110.0, 20.0, 1.2), Mode(270.0, 30.0, -0.4))
        driven, response = recorded(item, SWEEP, np.random.default_rng(1), (0.002, 0.002), 0.0)
        survey.write_text(table(1.0 / SWEEP.sample_rate, "t [s],control [g],item [g]", driven, response))
        effects.write_text(csv_text(record(1, Shaken(seconds=8.0))))
        found: list[Any] = [
            ic.vibration(run, profile=str(profile), control=["control"], response=["item"], tolerance="3 dB"),
            ic.vibration_profile(profile),
            ic.plan_vibration(profile=profile),
            ic.vibration_survey(survey, control=["control"]),
            ic.vibration_effects(effects),
        ]
        return tuple(curve for one in found for curve in one.results["curves"])


def test_the_control_is_drawn_beside_its_profile() -> None:
    curves = list(vibration_curves())
    columns = next(one["columns"] for one in curves if one["name"] == "vibration_control")
    density, profile, deviation, low, high = (
        np.array(columns[name]["values"]) for name in ("density", "profile", "deviation", "lo", "hi")
    )
    np.testing.assert_allclose(deviation, 10.0 * np.log10(density / profile), atol=1e-6)
    assert np.all((low < density) & (density < high))
    (picture,) = figures()["vibration"].pictures({"curves": curves, "results": [], "verdicts": []})
    above, _ = on_new_figure(picture, titled=True).axes
    drawn = [np.asarray(line.get_ydata(), float).tolist() for line in above.get_lines()]
    assert density.tolist() in drawn
    assert profile.tolist() in drawn


@pytest.mark.parametrize("verdicts", [JUDGED, []])
def test_changes_are_drawn_in_parts_of_what_is_allowed(verdicts: list[dict[str, Any]]) -> None:
    content = {"results": CHANGES, "verdicts": verdicts, "sequence": [{"test": "new", "against": "old"}]}
    (picture,) = figures()["changes"].pictures(content)
    expected = "new against old: bias y 1.40 ± 0.10 deg/s beyond what is allowed" if verdicts else (
        "new against old: largest change by its interval bias y, 1.40 ± 0.10 deg/s")  # fmt: skip
    assert picture.finding == expected
