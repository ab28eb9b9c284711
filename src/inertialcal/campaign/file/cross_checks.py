"""What one key of a campaign file says about another: names that lead somewhere, files that are there."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...core.errors import Problem
from ...core.schema.toml import At
from ...procedures import procedure_names, procedure_of
from .ground_checks import ground_checks
from .recording_checks import recording_checks, sensor_checks
from .requirement_checks import requirement_checks
from .schema import CampaignFile
from .test_checks import after_checks, against_checks, overlap_checks, procedure_checks

RESERVED = "model"  # test that the rows of the model of the sensor carry in results.json


def cross_checks(folder: Path | None, file: CampaignFile, at: At) -> list[Problem]:
    """Return everything that does not fit together.

    Parameters
    ----------
    folder : Path or None
        Of the campaign; None where files may lie anywhere.
    file : CampaignFile
        Valid by itself.
    at : callable
        Place of a key path, for messages.
    """
    return [
        *(p for name, sensor in file.sensors.items() for p in sensor_checks(name, sensor, at)),
        *(p for name, entry in file.recordings.items() for p in recording_checks(folder, file, name, entry, at)),
        *(p for number, test in enumerate(file.tests) for p in procedure_checks(file, number, test, at)),
        *(p for number, test in enumerate(file.tests) for p in against_checks(file, number, test, at)),
        *(p for number, test in enumerate(file.tests) for p in after_checks(file, number, test, at)),
        *_duplicates("tests", [test.id for test in file.tests], at),
        *_reserved(file, at),
        *_duplicates("requirements", [one.id for one in file.requirements], at),
        *overlap_checks(file, at),
        *_model_terms(file, at),
        *ground_checks(folder, file, at),
        *requirement_checks(file, at),
    ]


def _duplicates(table: str, ids: list[str], at: At) -> Iterator[Problem]:
    for number, one in enumerate(ids):
        if one in ids[:number]:
            what = f"duplicate id {one!r} in {table}: used before"
            why = "results could not be told apart"
            yield Problem(what, at(table, number, "id"), why, "Give each its own", "duplicate_id")


def _reserved(file: CampaignFile, at: At) -> Iterator[Problem]:
    names = {RESERVED, *(f"{RESERVED}_{sensor}" for sensor in file.sensors)}
    for number, test in enumerate(file.tests):
        if test.id in names:
            what = f"tests: id {test.id!r}: results have the rows of the model of the sensor under this name"
            yield Problem(what, at("tests", number, "id"), "they could not be told apart", "Rename it", "duplicate_id")


def _makes_model(procedure: str) -> bool:
    return procedure in procedure_names() and procedure_of(procedure).makes_model


def _model_terms(file: CampaignFile, at: At) -> Iterator[Problem]:
    uses = {test.id: test.use for test in file.tests if _makes_model(test.procedure)}
    lists = {}
    for term, names in file.model.terms.items():
        where = at("model", "terms", term)
        for name in names:
            if uses.get(name) != "fit":
                what = f"model.terms.{term}: {name!r} is no test with use = 'fit' that a model is made of"
                have = ", ".join(test for test, use in uses.items() if use == "fit")
                yield Problem(what, where, do=f"There are: {have or 'none'}", code="unknown_name")
        if term != "bias":
            lists[term] = set(names)
    if len({frozenset(names) for names in lists.values()}) > 1:
        what = f"model.terms: {', '.join(lists)} come from one reduction and need the same tests"
        yield Problem(what, at("model", "terms"), code="wrong_value")
