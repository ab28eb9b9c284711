"""Decision rules of a campaign: for all requirements, for one, and refused with the line where they cannot be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.load import load
from inertialcal.cli.shown.summary import verdicts_text
from inertialcal.core.errors import PlanError
from inertialcal.report.page import report_html

Write = Callable[..., Path]
AXIS = 'id = "R2"\nquantity = "scale_factor_error"\naxis = "x"\nlimit = "1.5 %"\n'
SIDE = AXIS.replace('limit = "1.5 %"', 'upper = "1.5 %"')


def with_rule(campaign: Write, head: str = "", own: str = "", requirement: str = AXIS) -> Path:
    """Write the campaign with a rule for all, and a second requirement with a rule of its own."""
    text = f"{head}\n[[requirements]]\n{requirement}{own}\n[[requirements]]\nid"
    return campaign(("[[requirements]]\nid", text))


@pytest.mark.parametrize(
    ("head", "own", "requirement", "line", "words"),
    [
        ('[decision]\nrule = "guard"', "", AXIS, 24, "'guard_factor'"),
        ('[decision]\nrule = "guard_factor"', "", AXIS, 24, "rule = 'guard_factor' needs factor"),
        ('[decision]\nrule = "guard_factor"\nfactor = -1', "", AXIS, 25, "greater than 0"),
        ('[decision]\nrule = "simple_acceptance"\nfactor = 1', "", AXIS, 25, "does not use factor"),
        ('[decision]\nrule = "false_accept_risk"\nrisk = "60 %"', "", AXIS, 25, "risk = 60 %"),
        ('[decision]\nrule = "test_uncertainty_ratio"\nratio = 4', "", SIDE, 27, "needs two limits, it has one"),
        ('[decision]\nrule = "test_uncertainty_ratio"\nratio = 4\notherwise = { rule = "guard_factor" }',
         "", AXIS, 26, "needs factor"),
        ("", 'decision = { rule = "false_accept_risk" }', AXIS, 29, "needs risk"),
        ("", 'decision = { rule = "false_accept_risk", risk = "2 %", process = { mean = "0 %" } }', AXIS, 29,
         "needs the standard deviation"),
        ("", 'decision = { rule = "false_accept_risk", risk = "2 %", process = { sd = "1 deg/s" } }', AXIS, 29,
         "sd of the process is '1 deg/s', its limit '1.5 %'"),
        ("", 'decision = { rule = "false_accept_risk", risk = "2 %", process = { in_tolerance = "95 %" } }', SIDE, 29,
         "in_tolerance needs two limits"),
        ("", 'decision = { rule = "false_accept_risk", risk = "2 %", process = { sd = "1 %" } }', SIDE, 29,
         "process needs its mean"),
        ('[decision]\nrule = "false_accept_risk"\nrisk = "2 %"\nprocess = { in_tolerance = "95 %" }', "", AXIS, 34,
         "requirement 'R1': a global risk is defined for a single figure"),
        ("", 'decision = { rule = "false_accept_risk", risk = "2 %", process = { sd = "1 %" } }',
         'id = "R2"\nquantity = "angle_random_walk"\nlimit = "1 deg/sqrt(h)"\n', 28,
         "a global risk is defined for a single figure"),
    ],
)  # fmt: skip
def test_what_cannot_be_decided_is_refused_with_its_line(
    campaign: Write, head: str, own: str, requirement: str, line: int, words: str
) -> None:
    with pytest.raises(PlanError) as caught:
        load(with_rule(campaign, head, own, requirement))
    found = [(p.where, p.what) for p in caught.value.problems]
    assert len(found) == 1
    assert found[0][0] == f"campaign.toml:{line}"
    assert words in found[0][1]


def test_a_rule_for_all_and_one_of_its_own(campaign: Write) -> None:
    folder = with_rule(
        campaign, '[decision]\nrule = "guard_factor"\nfactor = 1.0', 'decision = { rule = "simple_acceptance" }'
    )
    results = run(folder, write=False).results
    assert results["decision_rule"].startswith(
        "guard factor 1: PASS if the value lies inside the limits by 1 U or more"
    )
    by = {one["requirement"]: one for one in results["verification"]}
    assert by["R1"]["decision"] == {"rule": "guard_factor", "factor": 1.0, "binary": False}
    assert by["R2"]["rule"] == "simple acceptance: PASS if the value lies inside the limits, else FAIL"
    single = next(one for one in results["verdicts"] if one["requirement"] == "R2")
    assert (single["verdict"], single["accept_lower"], single["accept_upper"]) == ("PASS", -1.5, 1.5)
    assert 0.0 <= single["risk"] < 0.5
    half = 0.5 * (single["interval"]["hi"] - single["interval"]["lo"])
    assert single["ratio"] == pytest.approx(1.5 / half)
    assert single["margin"] == pytest.approx(1.5 - single["value"])
    over = next(one for one in results["verdicts"] if one["requirement"] == "R1" and one["interval"] is not None)
    assert over["accept_upper"] == pytest.approx(over["upper"] - (over["interval"]["hi"] - over["value"]))
    text = verdicts_text(results)
    assert "R2 by its own rule: simple acceptance" in text
    again = [one | {"requirement": "R3"} for one in results["verdicts"] if one["requirement"] == "R2"]
    both = verdicts_text({**results, "verdicts": [*results["verdicts"], *again]})
    assert "R2, R3 by their own rule: simple acceptance" in both
    assert "(PASS -1.5 to 1.5 %, false accept " in text
    page = report_html(results, None, {"made": "", "inputs": [], "versions": {}, "options": {}, "rerun": ""})
    assert "simple acceptance" in page
    assert "PASS from" in page


def test_a_global_risk_takes_the_stated_process(campaign: Write) -> None:
    own = 'decision = {{ rule = "false_accept_risk", risk = "2 %", process = {{ {} }} }}'
    tight = AXIS.replace("1.5 %", "1.05 %")

    def judged(process: str) -> dict[str, object]:
        folder = with_rule(campaign, own=own.format(process), requirement=tight)
        found: dict[str, object] = run(folder, write=False).results["verdicts"][0]
        return found

    good, poor = judged('in_tolerance = "99.9 %"'), judged('sd = "0.9 %"')
    assert good["accept_upper"] == pytest.approx(1.05)  # nearly all items conform: no guard band is needed
    assert "99.9 % in tolerance" in str(good["rule"])
    assert "standard deviation 0.9 %" in str(poor["rule"])


def test_the_default_is_as_it_was(campaign: Write) -> None:
    results = run(with_rule(campaign), write=False).results
    assert results["decision_rule"] == (
        "PASS if the 95 % interval lies inside the limits, FAIL if wholly outside, else INCONCLUSIVE;"
        " over several rates the 95 % hold for all together"
    )
