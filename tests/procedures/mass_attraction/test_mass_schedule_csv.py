"""Schedule as CSV: back with its bits, and refused with file and row where it is none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from inertialcal.core.errors import InertialcalError
from inertialcal.physics.motion.schedule import Schedule, repeated
from inertialcal.procedures.mass_attraction.schedule_csv import read_schedule, write_schedule

ROWS = """dwell,start [s],stop [s],position [cm],applied [ng]
1,0,100,10,23
2,120,220,40,-23
3,240,340,10,23
"""


@pytest.mark.parametrize(("u_applied", "mercury"), [(None, None), (0.1 / 3, [1e-9 / 3, 0.0, -2e-9, 0.0])])
def test_a_schedule_comes_back_with_its_bits(
    tmp_path: Path, u_applied: float | None, mercury: list[float] | None
) -> None:
    rng = np.random.default_rng(1)
    given = repeated(
        rng.normal(size=4), 1e-7 * rng.normal(size=4), cycles=25, dwell=100.1, move=20 / 3, drive="sine",
        u_applied=u_applied, mercury=mercury,
    )  # fmt: skip
    write_schedule(tmp_path / "s.csv", given)
    back = read_schedule(tmp_path / "s.csv")
    assert (back.mercury is None) == (mercury is None)
    for name in ("start", "position", "applied", *(["mercury"] if mercury else [])):
        assert getattr(back, name).tobytes() == getattr(given, name).tobytes()
    told = ("dwell", "move", "drive", "samples_per_cycle", "u_applied")
    assert [getattr(back, name) for name in told] == [getattr(given, name) for name in told]


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    given = Schedule(np.array([0.0, 120.0]), 100.0, 20.0, np.array([0.1, 0.2]), np.array([1e-7, -1e-7]))
    with pytest.raises(InertialcalError, match="it is a folder"):
        write_schedule(tmp_path, given)


def test_uneven_starts_come_back(tmp_path: Path) -> None:
    start, place, field = np.array([[0.0, 130.0, 250.0], [0.1, 0.2, 0.1], [1e-7, -1e-7, 1e-7]])
    given = Schedule(start, 100.0, 20.0, place, field)
    write_schedule(tmp_path / "s.csv", given)
    assert read_schedule(tmp_path / "s.csv").start.tolist() == [0.0, 130.0, 250.0]


def test_a_table_written_by_hand_is_custom_and_its_units_are_taken(tmp_path: Path) -> None:
    (tmp_path / "hand.csv").write_text(ROWS)
    found = read_schedule(tmp_path / "hand.csv")
    assert (found.drive, found.dwell, found.move, found.u_applied) == ("custom", 100.0, 20.0, None)
    assert found.position == pytest.approx([0.1, 0.4, 0.1])
    assert found.amplitude == pytest.approx(23e-9 * 9.80665)


@pytest.mark.parametrize("cycle", [(23.0, -23.0), (0.0, 23.0, 0.0, -23.0), (23.0, 23.0, -23.0, -23.0)])
def test_rows_tell_their_cycle_where_no_comment_does(tmp_path: Path, cycle: tuple[float, ...]) -> None:
    rows = [f"{i + 1},{120 * i},{120 * i + 100},{i},{cycle[i % len(cycle)]}" for i in range(5 * len(cycle))]
    (tmp_path / "hand.csv").write_text("\n".join([ROWS.splitlines()[0], *rows]) + "\n")
    assert read_schedule(tmp_path / "hand.csv").samples_per_cycle == len(cycle)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("120,220", "120,230", "hand.csv:3: a dwell of 110 s among dwells of 100 s"),
        ("120,220", "90,190", "dwell 2 starts at 90 s, before dwell 1 ends"),
        ("240,340,10,23", "240,340,10,", "hand.csv:4: applied is empty"),
        ("240,340,10,23", "240,340,10,NaN", "hand.csv:4"),
        (",-23", ",minus", "hand.csv:3: text 'minus' in number column"),
        ("position [cm]", "position", "'position' has no unit"),
        ("applied [ng]", "applied [deg/s]", "'applied' has the unit deg/s"),
        ("position [cm]", "place [cm]", "no column 'position'"),
        ("dwell,start", "# drive: triangle\ndwell,start", "drive 'triangle' is not known"),
        ("dwell,start", "# dwells a cycle: two\ndwell,start", "dwells a cycle: 'two' is not a whole number"),
        ("dwell,start", "# drive: sine\n# dwells a cycle: 1\ndwell,start", "does not repeat after 1 dwells"),
        ("10,23\n", "10,23\n4,360,460,20,0\n", "does not repeat after any number of dwells"),
        ("dwell,start", "# dwell: 100 m\ndwell,start", "# dwell: "),
        (
            "dwell,start",
            "# move: 30 s\ndwell,start",
            "hand.csv:4: a pause of 20 s, but moves take",
        ),
        ("dwell,start", "# u of applied: lots\ndwell,start", "# u of applied: "),
        ("2,120,220,40,-23\n3,240,340,10,23\n", "", r"1 dwell\(s\)"),
    ],
)
def test_what_is_no_schedule_is_refused_with_its_place(tmp_path: Path, old: str, new: str, words: str) -> None:
    (tmp_path / "hand.csv").write_text(ROWS.replace(old, new))
    with pytest.raises(InertialcalError, match=words):
        read_schedule(tmp_path / "hand.csv")


def test_the_mercury_of_a_meter_needs_an_angle(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"
    rows = ROWS.replace("[ng]", "[ng],mercury [{}]").replace("23\n", "23,1\n")
    path.write_text(rows.format("urad"), encoding="utf-8")
    np.testing.assert_allclose(read_schedule(path).mercury, 1e-6)  # type: ignore[arg-type]
    path.write_text(rows.format("m"), encoding="utf-8")
    with pytest.raises(InertialcalError, match=r"'mercury' has the unit m"):
        read_schedule(path)
    path.write_text(rows.format("rad").replace("-23,1", "-23,"), encoding="utf-8")
    with pytest.raises(InertialcalError, match="mercury is empty") as refused:
        read_schedule(path)
    assert "s.csv:3" in str(refused.value)
