"""Sample rates of the recordings of a test."""

from inertialcal.signals.time.sample_rates import rate_remarks


def test_rates_that_are_alike() -> None:
    assert rate_remarks([]) == ()
    assert rate_remarks([("a", "a.csv", 100.0)]) == ()
    assert rate_remarks([("a", "a.csv", 100.0), ("b", "b.csv", 102.0), ("c", "c.csv", 140.0)]) == ()


def test_the_recording_that_differs_is_named_with_its_file() -> None:
    (found,) = rate_remarks([("a", "a.csv", 100.0), ("b", "b.csv", 10.0), ("c", "c.csv", 101.0)])
    assert (found.code, found.where, found.subject) == ("sample_rate_disagrees", "b.csv", "b")
    assert found.what == "recording b has 10 Hz, most others 100 Hz"


def test_of_two_both_are_named() -> None:
    (found,) = rate_remarks([("a", "a.csv", 100.0), ("b", "b.csv", 10.0)])
    assert (found.where, found.what) == ("b.csv, a.csv", "recording b has 10 Hz, recording a 100 Hz")
