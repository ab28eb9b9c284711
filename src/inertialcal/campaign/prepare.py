"""A test made ready: its plan, and the readings of all its recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from ..core.errors import InertialcalError, Problem
from ..core.remarks import Remark
from .after import Bias
from .cross_checks import MODELLED
from .flip_inputs import prepared_flip
from .load import Campaign
from .mass_inputs import prepared_mass_attraction
from .modelling import Prepared
from .noise_inputs import prepared_static_noise
from .positions_inputs import prepared_positions
from .rate_table_inputs import prepared_rate_table
from .schema import Test
from .schema_sensors import Sensor
from .thermal_inputs import prepared_thermal

WAYS: dict[str, Callable[[Campaign, Test, Sensor], Prepared]] = {
    "rate_table": prepared_rate_table,
    "flip": prepared_flip,
    "thermal": prepared_thermal,
    "static_noise": prepared_static_noise,
    "mass_attraction": prepared_mass_attraction,
    "positions": prepared_positions,
}


def prepare(campaign: Campaign, number: int, found: Mapping[str, Any] | None = None) -> Prepared:
    """Return readings and plan of one test; problems get the place of the test where they have none.

    Parameters
    ----------
    campaign : Campaign
        As read.
    number : int
        Of the test.
    found : mapping of str to Result, optional
        Of tests that were reduced before, by name: what a test comes after is taken off. Without them nothing is.
    """
    test = campaign.file.tests[number]
    try:
        sensor = sensor_of(campaign, test)
        bias = next((Bias(name, found[name]) for name in test.after if found is not None), None)
        prepared = (
            WAYS[test.procedure](campaign, test, sensor)
            if bias is None
            else prepared_rate_table(campaign, test, sensor, bias)
        )
        inside = tuple(_inside(campaign, remark) for remark in prepared.readings.remarks)
        return replace(prepared, readings=replace(prepared.readings, remarks=inside))
    except InertialcalError as error:
        raise type(error)([placed(problem, campaign, number) for problem in error.problems]) from None


def _inside(campaign: Campaign, remark: Remark) -> Remark:
    """Tell files by their name in the campaign: results must not depend on where the folder lies."""
    prefix = f"{campaign.folder}/"
    return replace(remark, where=remark.where.replace(prefix, ""), what=remark.what.replace(prefix, ""))


def placed(problem: Problem, campaign: Campaign, number: int) -> Problem:
    """Files are told by their name in the campaign; what has no place gets that of its test."""
    where = problem.where.removeprefix(f"{campaign.folder}/") or campaign.at("tests", number)
    return replace(problem, where=where)


def sensor_of(campaign: Campaign, test: Test) -> Sensor:
    """Return the sensor that a test is about."""
    return campaign.file.sensors[campaign.file.recordings[test.recordings[0]].sensor]


def modelled_sensor(campaign: Campaign) -> Sensor:
    """Return the sensor that the model of a campaign is of: that of the first test for a fit."""
    fitted = (test for test in campaign.file.tests if test.use == "fit" and test.procedure in MODELLED)
    return sensor_of(campaign, next(fitted))
