"""A test of a campaign folder made ready: its plan, and the readings of all its recordings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...core.errors import InertialcalError, Problem
from ...core.remarks import Remark
from ...procedures import procedure_of
from ..file.load import Campaign
from ..file.schema import Test
from ..file.sensors import Sensor
from ..inputs.sources import Folder, Store
from .engine import Prepared, corrections_for, prepare_test


def prepare(
    campaign: Campaign, number: int, found: Mapping[str, Any] | None = None, store: Store | None = None
) -> Prepared:
    """Return readings and plan of one test; problems get the place of the test where they have none.

    Parameters
    ----------
    campaign : Campaign
        As read.
    number : int
        Of the test.
    found : mapping of str to Result, optional
        Of tests that were reduced before, by name: what a test comes after is taken off. Without them nothing is.
    store : Store, optional
        That holds its files; by default the folder of the campaign.
    """
    file, test = campaign.file, campaign.file.tests[number]
    try:
        corrections = [] if found is None else corrections_for(test, file.tests, found)
        prepared = prepare_test(file, test, campaign.standards, store or Folder(campaign.folder), corrections)
        inside = tuple(_inside(campaign, remark) for remark in prepared.readings.remarks)
        return replace(prepared, readings=replace(prepared.readings, remarks=inside))
    except InertialcalError as error:
        raise type(error)([placed(problem, campaign, number) for problem in error.problems]) from None


def _inside(campaign: Campaign, remark: Remark) -> Remark:
    """Name files as the campaign does: results must not depend on where the folder lies."""
    prefix = f"{campaign.folder}/"
    return replace(remark, where=remark.where.replace(prefix, ""), what=remark.what.replace(prefix, ""))


def placed(problem: Problem, campaign: Campaign, number: int) -> Problem:
    """Return a problem with its file as the campaign names it; what has no place gets that of its test."""
    where = problem.where.removeprefix(f"{campaign.folder}/") or campaign.at("tests", number)
    return replace(problem, where=where)


def sensors_of(campaign: Campaign, test: Test) -> dict[str, Sensor]:
    """Return the sensors of the recordings of a test, by name."""
    names = (campaign.file.recordings[name].sensor for name in test.recordings)
    return {name: campaign.file.sensors[name] for name in names}


def sensor_of(campaign: Campaign, test: Test, kind: str = "") -> Sensor:
    """Return the sensor of a test: of a kind, where the test has several, else the first."""
    first, *others = sensors_of(campaign, test).values()
    return next((one for one in others if one.kind == kind), first)


def modelled_sensor(campaign: Campaign) -> Sensor:
    """Return the sensor that the model of a campaign is of: that of the first test for a fit."""
    fitted = (test for test in campaign.file.tests if test.use == "fit" and procedure_of(test.procedure).makes_model)
    return sensor_of(campaign, next(fitted))
