"""The likely cause of a recording that reads something else than was applied."""

import pytest

from inertialcal.procedures.agreement import likely_cause, unit_mistaken

TOLERANCE = 0.2


@pytest.mark.parametrize(
    ("response", "kind", "code", "says"),
    [
        ({"x": -1.01, "y": 0.01}, "angular_rate", "sign_disagrees", "inverted"),
        ({"x": 0.01755, "y": 1e-4}, "angular_rate", "unit_disagrees", "in rad/s, taken for deg/s"),
        ({"x": -57.1}, "angular_rate", "unit_disagrees", "in deg/s, taken for rad/s, with the sign inverted"),
        ({"x": 0.1019}, "acceleration", "unit_disagrees", "in g, taken for m/s^2"),
        ({"x": 9.81}, "acceleration", "unit_disagrees", "in m/s^2, taken for g"),
        ({"x": 1003.0}, "", "unit_disagrees", "milli that was not stated"),
        ({"x": 1.02e-6}, "", "unit_disagrees", "micro, the readings have not"),
        ({"x": 0.01, "y": -0.99}, "angular_rate", "axes_disagree", "y reads -0.99"),
        ({"x": 1.4, "y": 0.01}, "angular_rate", "gain_disagrees", "+1.4"),
        ({"x": 0.0, "y": 0.0}, "angular_rate", "gain_disagrees", "+0 "),
    ],
)
def test_the_cause_is_named(response: dict[str, float], kind: str, code: str, says: str) -> None:
    """Each cause by its code, with the ratio and the units in its text."""
    found = likely_cause(response, "x", TOLERANCE, kind)
    assert found is not None
    assert found.code == code
    assert says in found.what


def test_a_sample_rate_is_a_cause_only_where_it_matters() -> None:
    """Half of an angle is a sample rate twice too high; half of a rate is a gain."""
    assert likely_cause({"x": 0.5}, "x", TOLERANCE, sampled=True).code == "sample_rate_disagrees"  # type: ignore[union-attr]
    assert likely_cause({"x": 0.5}, "x", TOLERANCE).code == "gain_disagrees"  # type: ignore[union-attr]


@pytest.mark.parametrize("response", [{"x": 0.85}, {"x": 1.1, "y": 0.3}, {"y": 1.0}, {"x": float("nan")}])
def test_a_sound_or_unknown_response_has_no_cause(response: dict[str, float]) -> None:
    """What lies within the tolerance, and what was not read."""
    assert likely_cause(response, "x", TOLERANCE) is None


def test_a_remark_names_recording_and_file() -> None:
    """An error, as no model may come of it."""
    found = likely_cause({"x": -1.0}, "x", TOLERANCE)
    assert found is not None
    remark = found.remark("x3", "x3.csv", "x")
    assert (remark.severity, remark.where) == ("error", "x3.csv")
    assert "x3: x reads -1" in remark.what


def test_no_factor_between_the_units_and_prefixes() -> None:
    """A factor of two is no unit."""
    assert unit_mistaken(2.0, "angular_rate") == unit_mistaken(2.0, "acceleration") == ""
