"""Write the files of a release, which every later one must read: ``make keep`` before it is tagged.

Each release has a folder of its own, by its version; one that is there is not written again. The model is typed here
with round figures, so that what a file compensates to is known without the code that wrote it.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np

from inertialcal.campaign.certificate.issue import certificate
from inertialcal.campaign.models.find import load_model
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import Kind
from inertialcal.core.recording import Channel, Recording
from inertialcal.files.models.model_file import export, load_model_file
from inertialcal.files.models.model_json import write_model
from inertialcal.files.write.recording import write
from inertialcal.physics.motion.schedule import Schedule, repeated
from inertialcal.procedures.mass_attraction.schedule_csv import write_schedule
from inertialcal.sensors.model.model_set import ModelSet
from inertialcal.sensors.model.sensor_model import Item, SensorModel
from inertialcal.sensors.model.terms import values

KEPT = Path(__file__).parent
ROOT = KEPT.parents[1]
MATRIX = ((1.01, 0.002, -0.001), (0.003, 0.98, 0.002), (-0.002, 0.001, 1.02))
BIAS = {"air": (0.01, -0.02, 0.03), "vacuum": (0.02, -0.01, 0.01)}  # rad/s, or m/s2
READ = {"imucal": 1, "kalibr-model": 1, "imu-tk": 0, "realsense": 1, "ros": 1, "px4": 1, "ardupilot": 1}
# format -> models beside the first
ENDINGS = ("csv", "parquet", "npz", "h5", "mat", "mcap")  # of recordings
START = np.datetime64("2026-11-29T00:00:00", "ns")
RATE = 100  # Hz
N = 50


def recording() -> Recording:
    """Return rates and specific forces of three axes, each sample another one."""
    time = START.astype(np.int64) + np.arange(N) * (1_000_000_000 // RATE)
    kinds = (("gyro", "rad/s"), ("acc", "m/s^2"))
    columns = [(f"{name}_{axis}", unit, axis, name) for name, unit in kinds for axis in "xyz"]
    channels = (
        Channel(name, np.sin(np.arange(N) + place), unit, axis=axis, quantity=kind)
        for place, (name, unit, axis, kind) in enumerate(columns)
    )
    return Recording((*channels,), time, epoch="utc")


def schedule() -> Schedule:
    """Return two positions of a mass, by turns."""
    return repeated([0.1, 0.4], [7e-7, 2e-7], cycles=4, dwell=100.0, move=20.0, drive="abab")


def model(kind: Kind, condition: str = "") -> SensorModel:
    """Return a linear model of three axes, each parameter with a standard uncertainty of 0.001."""
    made = SensorModel(kind, ("x", "y", "z"), np.ones(3), "rad/s" if kind == "gyro" else "m/s2", np.array([MATRIX]),
                       np.array(BIAS[condition or "air"]), Item("maker", "part", "7"), condition,
                       input_range=np.array([[-5.0, 5.0]] * 3))  # fmt: skip
    listed = made.parameters
    covariance = 1e-6 * np.eye(len(listed))
    names, units = tuple(one.name for one in listed), tuple(one.unit for one in listed)
    scatter = Component("scatter", "A", covariance, np.full(len(listed), 9.0))
    estimate = Estimate(names, values(listed, made.terms), units, (scatter,))
    return replace(made, estimate=estimate, judged=True)


def main() -> None:
    """Write the folder of the version that pyproject.toml states, or of the one named."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    folder = KEPT / (sys.argv[1] if len(sys.argv) > 1 else project["version"])
    if folder.exists():
        sys.exit(f"{folder} is there: the files of a release are never written again")
    folder.mkdir()
    write_model(folder / "gyro.json", model("gyro"))
    write_model(folder / "accelerometer.json", model("accelerometer"))
    write_model(folder / "gyro_by_condition.json", ModelSet((model("gyro", "air"), model("gyro", "vacuum"))))
    write_model(folder / "from_counts.json", load_model("flight_unit"))
    own = load_model_file(folder / "gyro.json")
    other = load_model_file(folder / "accelerometer.json")
    for name, others in READ.items():
        export(own, name, folder / f"exported.{name}", others=[other] * others)
    for ending in ENDINGS:
        write(folder / f"recording.{ending}", recording())
    write_schedule(folder / "schedule.csv", schedule())
    with tempfile.TemporaryDirectory() as work:
        from certified import made

        run = made("reinel1969", Path(work) / "campaign")
        shutil.copy(run / "out" / "results.json", folder)
        shutil.copy(run / "campaign.toml", folder)
        shutil.copy(run / "table4.csv", folder)
        certificate(run, folder / "certificate.xml")


if __name__ == "__main__":
    main()
