"""Two-line elements: read with all their checks, propagated as published, turned to earth-fixed axes."""

from __future__ import annotations

import sys
from datetime import UTC, datetime

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.physics.elements import chosen, parse_elements, sidereal_angle, track_by

pytest.importorskip("sgp4")
VANGUARD = """0 VANGUARD 1
1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753
2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667
"""  # AIAA 2006-6753, the first of its test cases


def refused(text: str) -> DataError:
    with pytest.raises(DataError) as caught:
        parse_elements(text, "a.tle")
    assert caught.value.problems[0].code == "elements"
    return caught.value


def test_a_published_position_comes_out() -> None:
    (one,) = parse_elements(VANGUARD, "a.tle")
    assert (one.name, one.number, one.where) == ("VANGUARD 1", "00005", "a.tle:2")
    assert one.epoch_ns == pytest.approx(datetime(2000, 6, 27, 18, 50, 19, 733568, tzinfo=UTC).timestamp() * 1e9)
    found = track_by(one, np.array([0.0]), one.epoch_ns)
    assert np.linalg.norm(found.position) == pytest.approx(
        np.linalg.norm([7022465.29266, -1400082.96755, 39.95155]), abs=1.0
    )
    assert found.position[0, 2] == pytest.approx(39.95155, abs=1.0)


def test_axes_of_date_turn_to_earth_fixed_ones_as_published() -> None:
    """AIAA 2006-6753, appendix C: 2004-04-06 07:51:28.386009 UTC, UT1 - UTC = -0.4399619 s."""
    ns = int(datetime(2004, 4, 6, 7, 51, 28, tzinfo=UTC).timestamp()) * 10**9 + 386_009_000
    angle = float(sidereal_angle(ns, np.array([-0.4399619]))[0])
    x, y = 5094.18010720, 6127.64470520
    found = (x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle))
    assert found == pytest.approx((-1033.47503120, 7901.30558560), abs=2e-4)  # [km]: terms of the equinox are 8 cm
    assert np.hypot(found[0] + 1033.47938300, found[1] - 7901.29527540) < 0.02  # what the pole moves: 20 m at most


def test_an_uncertainty_grows_with_age_alike_before_and_after() -> None:
    (one,) = parse_elements(VANGUARD)
    day = 86_400 * 10**9
    u = [track_by(one, np.array([0.0]), one.epoch_ns + k * day).u for k in (-2, 0, 2)]
    assert u[0] == pytest.approx(u[2])
    assert u[1][0] == pytest.approx(np.hypot(1e3, 270.0))
    assert u[2][0] == pytest.approx(np.sqrt(1e3**2 + 4e3**2 + 270.0**2))


@pytest.mark.parametrize(("days", "side"), [(8.0, "after"), (-40.0, "before")])
def test_elements_of_another_week_are_refused(days: float, side: str) -> None:
    (one,) = parse_elements(VANGUARD, "a.tle")
    with pytest.raises(DataError, match=f"{abs(days):g} d {side} the epoch") as caught:
        track_by(one, np.array([0.0]), one.epoch_ns + int(days * 86_400e9))
    assert caught.value.problems[0].code == "elements_old"


def test_the_age_counts_at_the_far_end_of_a_long_record() -> None:
    (one,) = parse_elements(VANGUARD)
    with pytest.raises(DataError, match="after the epoch"):
        track_by(one, np.array([0.0, 8 * 86_400.0]), one.epoch_ns)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("34.2682", "34.2683", "checksum 7; the line adds up to 8"),
        ("4753\n", "475\n", "68 characters, need 69"),
        ("2 00005", "2 00006", "checksum"),
        (VANGUARD[VANGUARD.index("2 00005"):], "", "without its line 2"),
        (VANGUARD[VANGUARD.index("1 00005"):VANGUARD.index("2 00005")], "", "without its line 1"),
        (VANGUARD, "nothing of the kind\n", "no two-line elements"),
    ],
)  # fmt: skip
def test_lines_that_are_not_whole_are_refused(old: str, new: str, said: str) -> None:
    assert said in str(refused(VANGUARD.replace(old, new)))


def test_a_checksum_that_fits_does_not_make_two_satellites_one() -> None:
    second = VANGUARD.splitlines()[2]
    text = VANGUARD.replace(second, second.replace("2 00005", "2 00014"))  # 0 + 5 is 1 + 4
    assert "different satellites: 00005 and 00014" in str(refused(text))


def test_endings_of_lines_blanks_and_comments_do_not_matter() -> None:
    text = "\ufeff# of a catalogue\r\n\r\n" + VANGUARD.replace("\n", "  \r\n")
    assert parse_elements(text)[0].second == parse_elements(VANGUARD)[0].second


def test_the_nearest_set_of_the_satellite_that_is_named_is_taken() -> None:
    first, second = VANGUARD.splitlines()[1:]
    later = first.replace("00179.7", "00181.7").replace("4753", "4756")
    other = [one.replace("00005", "00041") for one in (first, second)]
    sets = parse_elements("\n".join(["OURS", first, second, "OURS", later, second, "OTHER", *other]))
    with pytest.raises(DataError, match=r"elements of 2 satellites: OURS \(00005\), OTHER \(00041\)"):
        chosen(sets, None, sets[0].epoch_ns)
    assert chosen(sets, "ours", sets[1].epoch_ns) is sets[1]
    assert chosen(sets, "41", sets[0].epoch_ns) is sets[2]
    with pytest.raises(DataError, match="no elements of 'MINE'"):
        chosen(sets, "MINE", 0)


def test_a_package_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    (one,) = parse_elements(VANGUARD)
    monkeypatch.setitem(sys.modules, "sgp4.api", None)
    with pytest.raises(DataError, match=r"pip install 'inertialcal\[orbit\]'") as caught:
        track_by(one, np.array([0.0]), one.epoch_ns)
    assert caught.value.problems[0].code == "missing_extra"


def test_a_satellite_that_has_decayed_is_refused() -> None:
    lines = VANGUARD.splitlines()
    low = lines[2].replace("10.82419157", "17.90000000")
    low = low[:68] + str((sum(map(int, filter(str.isdigit, low[:68]))) + low[:68].count("-")) % 10)
    (one,) = parse_elements("\n".join([lines[1], low]))
    with pytest.raises(DataError, match="cannot be propagated"):
        track_by(one, np.array([0.0]), one.epoch_ns)
