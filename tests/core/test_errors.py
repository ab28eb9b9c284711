"""Errors: every part reaches the reader, and scripts get a stable word and an exit status."""

from __future__ import annotations

import pickle

import pytest

from inertialcal.core.errors import DataError, InertialcalError, PlanError, Problem, StoreError, UsageError

FULL = Problem("unit 'furlong' is not known", "run.csv:3", "nothing converts", "Write deg/s", "unknown_unit")


def test_all_parts_on_one_line() -> None:
    assert str(FULL) == "run.csv:3: unit 'furlong' is not known (nothing converts). Write deg/s"


@pytest.mark.parametrize(
    ("problem", "text"),
    [
        (Problem("no data"), "no data"),
        (Problem("no data", where="a.csv"), "a.csv: no data"),
        (Problem("no data", why="nothing to fit"), "no data (nothing to fit)"),
        (Problem("no data", do="Record more"), "no data. Record more"),
    ],
)
def test_absent_parts_leave_no_trace(problem: Problem, text: str) -> None:
    assert str(problem) == text


def test_parts_for_json() -> None:
    assert FULL.to_dict() == {
        "what": "unit 'furlong' is not known",
        "where": "run.csv:3",
        "why": "nothing converts",
        "do": "Write deg/s",
        "code": "unknown_unit",
    }
    assert Problem("no data").to_dict()["code"] == "refused"


def test_error_of_parts_of_one_problem_and_of_many() -> None:
    of_parts = DataError(FULL.what, FULL.where, FULL.why, FULL.do, FULL.code)
    of_one, of_many = DataError(FULL), DataError([FULL, Problem("no data")])
    assert of_parts.problems == of_one.problems == (FULL,)
    assert str(of_parts) == str(of_one) == str(FULL)
    assert of_many.problems == (FULL, Problem("no data"))
    assert str(of_many) == f"{FULL}\nno data"


@pytest.mark.parametrize(("error", "status"), [(DataError, 3), (PlanError, 3), (UsageError, 2), (StoreError, 3)])
def test_exit_status(error: type[InertialcalError], status: int) -> None:
    assert error.exit_status == status
    with pytest.raises(InertialcalError, match="no data"):
        raise error("no data")


def test_problems_survive_the_way_between_processes() -> None:
    sent = DataError([FULL, Problem("no data")])
    received = pickle.loads(pickle.dumps(sent))
    assert received.problems == sent.problems
    assert str(received) == str(sent)
