"""A simulated campaign reduced without files: the campaign file read from its text, the recordings from memory.

Everything after reading is done by the engine, as it is for files. A test holds both ways to the same figures.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import lru_cache

from ...core.influence import Standards
from ...core.results import Row
from ...core.schema.standards import STANDARDS
from ...procedures import procedure_of
from ...procedures.protocol import Result, Tested
from ...rigs.protocol import SEED, Twin
from ..file.schema import CampaignFile, Test
from ..inputs.sources import Memory
from .engine import corrections_for, order_of, prepare_test, reduce_test


@dataclass(frozen=True, eq=False)
class Fitted:
    """A test with ``use = "fit"`` that was reduced.

    Parameters
    ----------
    test, procedure : str
        Its name, and that of its procedure.
    result : Result
        SI.
    rows : tuple of Row or None
        What is held against the truth, with what the test has against another; None where the estimate says all.
    """

    test: str
    procedure: str
    result: Result
    rows: tuple[Row, ...] | None = None


def fitted_tests(twin: Twin) -> list[Fitted]:
    """Return the tests of a twin with ``use = "fit"``, reduced.

    Raises
    ------
    DataError
        As the chain and the procedure say, where the twin has a fault.
    """
    file, standards = _campaign(twin.campaign)
    tests = [test for test in file.tests if test.use == "fit"]
    store = Memory(twin.recordings, {file: extra.content for file, extra in twin.extras.items()})
    results: dict[str, Result] = {}
    for test in (tests[number] for number in order_of(tests)):
        corrections = corrections_for(test, tests, results)
        results[test.id] = reduce_test(prepare_test(file, test, standards, store, corrections))
    return [Fitted(test.id, test.procedure, results[test.id], _rows(test, tests, results)) for test in tests]


def fit_results(twin: Twin) -> list[Result]:
    """Return the results of the tests of a twin with ``use = "fit"``.

    Raises
    ------
    DataError
        As the chain and the procedure say, where the twin has a fault.
    """
    return [one.result for one in fitted_tests(twin)]


def _rows(test: Test, tests: list[Test], results: dict[str, Result]) -> tuple[Row, ...] | None:
    """Return what is held against the truth: rows of the test, and those against another one."""
    procedure, result = procedure_of(test.procedure), results[test.id]
    rows = procedure.truths(result)
    if rows is None:
        return None
    other = next((one for one in tests if one.id == test.against), None)
    if other is None:
        return tuple(rows)
    of_other = Tested(other.id, other.condition, other.use, None, None, results[other.id])
    return (*rows, *(procedure.against(result, of_other, test.condition) or ()))


@lru_cache(4)
def _campaign(text: str) -> tuple[CampaignFile, Standards]:
    """Read the campaign file, which all seeds of a rig may share."""
    file = CampaignFile.model_validate(tomllib.loads(text.replace(SEED, "0")))
    standards = {
        f"{standard}.{name}": entry.influence(STANDARDS[standard][name], standard, name)
        for standard, quantities in file.standards.items()
        for name, entry in quantities.items()
    }
    return file, standards
