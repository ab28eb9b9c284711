"""What the page says of noise: what each record is worth, in the words of the command line."""

from __future__ import annotations

import re
from typing import Any

import pytest

from inertialcal.report import findings
from inertialcal.report.numbers import Number, time, wrap
from inertialcal.report.page import environment
from inertialcal.report.record_length import by_test, explained, finding, reaches
from inertialcal.report.sections import sections
from written_rows import fields

DOUBT = "in doubt: the terms do not explain the Allan deviation"
SHORT = "record too short; 80 min would show it at this limit"


def row(quantity: str, value: float | None, status: str = "estimated", **more: Any) -> dict[str, Any]:
    return {
        "quantity": quantity, "axis": "x", "test": "still", **fields(), "value": value, "u": 0.01, "dof": None,
        "unit": "deg/h", "interval": None, "status": status,
    } | more  # fmt: skip


def curve(test: str = "still", **values: list[Any]) -> dict[str, Any]:
    columns: dict[str, Any] = {
        "term": ["angle_random_walk", "gauss_markov_sigma"], "relative_error": [0.5, None], "wanted": [10.0, None],
        "record": [8 / 60.0, 8 / 60.0], "needed": [8 / 60.0, 80 / 60.0],
    } | values  # fmt: skip
    units = {"relative_error": "%", "wanted": "%", "record": "h", "needed": "h"}
    shown = {name: {"unit": units.get(name, ""), "values": each} for name, each in columns.items()}
    return {"name": "record_length", "test": test, "axis": "x", "columns": shown}


def told(said: findings.Finding) -> str:
    return re.sub("<[^>]*>", "", findings.html(said))


def found(*curves: dict[str, Any], rows: list[dict[str, Any]] | None = None) -> list[Any]:
    return reaches(wrap(list(curves), "/curves"), wrap(rows or [], "/results"))


def rendered(name: str, **content: Any) -> str:
    return " ".join(re.sub("<[^>]*>", " ", environment().get_template(f"{name}.html").render(content)).split())


@pytest.mark.parametrize(
    ("hours", "said"), [(8 / 60.0, "8 min"), (53.3, "2.2 days"), (6.67, "6.7 h"), (110 / 3600.0, "110 s")]
)
def test_lengths_are_said_in_the_unit_of_people(hours: float, said: str) -> None:
    assert re.sub("<[^>]*>", "", str(time(Number(hours, "/at"), "h"))) == said


def test_the_finding_counts_what_is_known_and_what_is_not_found() -> None:
    assert told(finding(found(curve()))) == "One term known to 10 % or better; one of two terms not detected"
    poor = curve(relative_error=[31.0, None], needed=[15.0, 1.3])
    said = (
        "Angle random walk of x: uncertainty 31 %; a recording of 15 h would give 10 %; one of two terms not detected"
    )
    assert told(finding(found(poor))) == said
    assert " of x in still: uncertainty" in told(finding(found(poor, curve("other"))))
    assert told(finding(found(curve(relative_error=[None, None])))) == "None of two terms detected"


def test_terms_in_doubt_are_not_known() -> None:
    doubtful = found(curve(), rows=[row("angle_random_walk", 1.0, **fields(reason=DOUBT))])
    assert told(finding(doubtful)).startswith(f"Angle random walk of x: {DOUBT}")
    rows = wrap(
        [row("angle_random_walk", 1.0, **fields(reason=DOUBT)), row("bias_instability", 2.0, **fields(reason=DOUBT))],
        "",
    )
    assert told(findings.of_test("static_noise", rows, [])).endswith(f", on x; {DOUBT}")


def test_a_test_of_noise_without_a_random_walk_says_what_it_found() -> None:
    rows = [row("angle_random_walk", 0.1, "upper_limit", u=None), row("bias_instability", 30.06)]
    assert (
        told(findings.of_test("static_noise", wrap(rows, ""), []))
        == "Largest bias instability 30.060 ± 0.010 deg/h, on x"
    )
    assert told(findings.of_test("static_noise", wrap(rows[:1], ""), [])) == "No noise term could be estimated"


def test_the_section_tells_why_and_how_long_and_the_table_of_the_test_does_not_again() -> None:
    rows = [
        row("gauss_markov_sigma", 13.0, "upper_limit", u=None, **fields(reason=SHORT)),
        row("angle_random_walk", 0.2),
    ]
    known = found(curve(), rows=rows)
    shown = rendered("noise", tests=by_test(known))
    assert "still : uncertainty of each term from recordings of 8 min" in shown
    assert f"Gauss-Markov size x not detected {SHORT}" in shown
    assert "angle random walk x 0.5 % long enough for 10 %" in shown
    (section,) = sections(wrap(rows, "/results"), [], [], [])
    table = rendered("lines", lines=section.lines, ways=section.ways, elsewhere=explained(known))
    assert "upper limit" in table
    assert "too short" not in table
    assert "too short" in rendered("lines", lines=section.lines, ways=section.ways, elsewhere=set())


def test_each_of_several_records_has_its_column_in_a_table_of_its_own() -> None:
    rows = [row("angle_random_walk", 0.2)]
    rows += [row("angle_random_walk", 0.2 + 0.1 * k, **fields(f"run day{k} alone")) for k in (1, 2)]
    (section,) = sections(wrap(rows, "/results"), [], [], [])
    assert section.ways == []
    assert [name for _, name in section.alone] == ["day1", "day2"]
    assert "day1 day2 angle random walk x deg/h 0.300 ± 0.010 0.400 ± 0.010" in rendered(
        "alone", lines=section.lines, names=section.alone
    )


def test_what_only_single_records_have_is_no_empty_line_of_the_table_of_all() -> None:
    rows = [row("angle_random_walk", 0.2), row("rate_ramp", 0.1, **fields("run day1 alone"))]
    rows += [row("bias_instability", 0.3, **fields("as_published"))]
    (section,) = sections(wrap(rows, "/results"), [], [], [])
    assert [line.quantity for line in section.together] == ["angle_random_walk", "bias_instability"]
    table = rendered("lines", lines=section.together, ways=section.ways, elsewhere=set())
    assert "bias instability x" in table
    assert "rate ramp" not in table
