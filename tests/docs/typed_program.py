"""A program of somebody else, as a type checker reads it: `assert_type` refuses what is `Any`. It is never run."""

from __future__ import annotations

from pathlib import Path
from typing import assert_type

import numpy as np
from numpy.typing import NDArray

import inertialcal as ic

Numbers = NDArray[np.float64]


def calibrated(folder: Path) -> ic.SensorModel:
    """Reduce files, run a campaign, and return its model."""
    found = ic.rate_table(folder / "table.csv", axis="x", zero_reference=True)
    assert_type(found, ic.Reduced)
    assert_type(found.rows[0], ic.Row)
    assert_type(found.rows[0].value, float | None)
    assert_type(found.rows[0].interval, ic.Interval | None)
    assert_type(found.models, dict[str, ic.SensorModel])
    for other in (ic.flip, ic.thermal, ic.mass_attraction, ic.positions, ic.sensitivity, ic.allan, ic.psd, ic.sine):
        assert_type(other(folder / "imu.csv").remarks, tuple[ic.Remark, ...])
    outcome = ic.run(folder, pdf=True)
    assert_type(outcome, ic.Outcome)
    assert_type(outcome.verdict, str)
    assert_type(ic.load_models(folder / "out/model.json"), ic.ModelSet)
    model = ic.load_model(folder / "out/model.json", "air")
    assert_type(model.estimate, ic.Estimate | None)
    assert_type(model.matrix, Numbers)
    return model


def compensated(model: ic.SensorModel, path: Path) -> Numbers:
    """Apply the model to a recording."""
    recording = ic.read(path, units={"x": "deg/s"})
    assert_type(recording, ic.Recording)
    assert_type(recording.channels, tuple[ic.Channel, ...])
    assert_type(ic.info(recording), ic.Survey)
    assert_type(ic.read_table(path), ic.Table)
    done = ic.compensate(model, recording, uncertainty=True)
    assert_type(ic.write(path.with_suffix(".h5"), done), tuple[ic.Remark, ...])
    return done.array(["x", "y", "z"])


def main() -> None:
    """Say what was refused, and why."""
    try:
        with ic.max_memory("1 GiB"):
            print(compensated(calibrated(Path()), Path("imu.csv")), ic.__version__)
    except ic.InertialcalError as error:
        assert_type(error.problems[0], ic.Problem)
        print(error.problems[0].do)


if __name__ == "__main__":
    main()
