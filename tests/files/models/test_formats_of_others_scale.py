"""A scale factor that no reading gave is not handed out as 1."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import AXES, Key, Origin
from inertialcal.files.models.model_file import export, load_model_file
from inertialcal.files.models.model_json import dump_model
from inertialcal.sensors.model.assemble import model_from


def at_rest(folder: Path, **values: float) -> Path:
    """Write the model of gyros of which only the bias was estimated."""
    keys = tuple(Key("bias", axis) for axis in AXES)
    parts = (Component(Origin("noise"), "A", 1e-8 * np.eye(3)),)
    estimate = Estimate(keys, np.array([0.01, 0.02, -0.01]), ("rad/s",) * 3, parts)
    path = folder / "gyro.json"
    path.write_text(dump_model(model_from(estimate, "gyro", AXES, values=values)), encoding="utf-8")
    return path


@pytest.mark.parametrize("to", ["imucal", "c", "python"])
def test_unknown_scale_factor_is_refused(tmp_path: Path, to: str) -> None:
    source = load_model_file(at_rest(tmp_path))
    with pytest.raises(DataError) as refused:
        export(source, to, tmp_path / "out", unjudged=True)
    assert refused.value.problems[0].code == "scale_factor_unknown"
    assert not (tmp_path / "out").exists()
    told = export(source, to, tmp_path / "out", unjudged=True, nominal=True)
    assert "scale_factor_unknown" in {one.code for one in told.remarks}


def test_value_without_uncertainty_is_handed_out(tmp_path: Path) -> None:
    known = {"scale_factor_error_x": 0.028, "scale_factor_error_y": -0.018, "scale_factor_error_z": -0.002}
    source = load_model_file(at_rest(tmp_path, **known))
    assert set(known) <= set(source.model.not_estimated)
    export(source, "imucal", tmp_path / "out", unjudged=True)
    content = json.loads((tmp_path / "out").read_text(encoding="utf-8"))
    assert np.degrees(np.diag(content["K_g"])) == pytest.approx([1.028, 0.982, 0.998])
