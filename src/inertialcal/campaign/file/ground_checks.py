"""What can be said of the ground models of a campaign before any recording is read."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...core.errors import InertialcalError, Problem
from ...core.schema.toml import At
from ...procedures import procedure_names, procedure_of
from ..inputs.ground import chain_model, has_model
from .schema import CampaignFile
from .sensors import Sensor


def ground_checks(folder: Path | None, file: CampaignFile, at: At) -> Iterator[Problem]:
    """Yield what is wrong with ground models, or with what is done with them.

    Parameters
    ----------
    folder : Path or None
        Of the campaign; None where files may lie anywhere.
    file : CampaignFile
        Valid by itself.
    at : callable
        Place of a key path, for messages.
    """
    for name, sensor in file.sensors.items():
        if has_model(sensor):
            yield from _model(folder, name, sensor, at)
    for number, test in enumerate(file.tests):
        sensors = {file.recordings[one].sensor for one in test.recordings if one in file.recordings}
        modelled = [name for name in sorted(sensors) if name in file.sensors and has_model(file.sensors[name])]
        if modelled and not _takes_model(test.procedure):
            what = f"test {test.id!r}: sensor {modelled[0]!r} has a ground model in its chain"
            why = f"a {test.procedure} is made of readings that no model has changed"
            do = "Give the recordings another sensor without it"
            yield Problem(what, at("tests", number, "recordings"), why, do, "wrong_value")


def _takes_model(procedure: str) -> bool:
    return procedure in procedure_names() and procedure_of(procedure).inputs.ground_model != "refused"


def _model(folder: Path | None, name: str, sensor: Sensor, at: At) -> Iterator[Problem]:
    key = "model" if sensor.chain.model is not None else "ground"
    where = at("sensors", name, "chain", key)
    if sensor.kind != "accelerometer":
        what = f"sensors.{name}.chain.{key}: a ground model is of a head of accelerometers"
        yield Problem(what, where, do="Leave it out; for a gyro: inertialcal compensate", code="wrong_value")
        return
    if folder is not None and sensor.chain.model is not None and not _is_inside(folder, sensor.chain.model):
        what = f"sensors.{name}.chain.model: {sensor.chain.model!r} lies outside the campaign folder"
        do = "Copy the file into the campaign folder"
        yield Problem(what, where, "a campaign must be complete in its folder", do, "outside")
        return
    try:
        chain_model(sensor, folder or Path())
    except InertialcalError as error:
        first = error.problems[0]
        file = f" = {sensor.chain.model!r}" if sensor.chain.model is not None else ""
        what = f"sensors.{name}.chain.{key}{file}: {first.what}"
        yield Problem(what, where, first.why, first.do, first.code or "wrong_value")


def _is_inside(folder: Path, given: str) -> bool:
    try:
        root = folder.resolve()
        return (root / given).resolve().is_relative_to(root)
    except (OSError, ValueError, RuntimeError):
        return False
