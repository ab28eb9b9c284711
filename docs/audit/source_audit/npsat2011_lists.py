"""Appendix B: time stamps, what was cut from the runs, angles turned."""

from __future__ import annotations

from itertools import pairwise

from .figures import Figure, Section, figure
from .npsat2011_fits import DOC
from .printed import Printed, Recomputed, printed
from .table_files import by, table

Told = dict[str, Printed]


def list_sections(told: Told) -> tuple[Section, ...]:
    """Return Appendix B."""
    return (_stamps(), _vacuum_runs(told), _rotations())


def _stamps() -> Section:
    """Later parts of a test begin after the earlier ended; stamps of 2010 have ten digits."""
    rows = [row for row in table(DOC, "appendix_b1_thermal_tests") if row["unix_start_printed_s"]]
    figures: list[Figure] = []
    for first, second in pairwise(rows):
        same = first["acs_id"] == second["acs_id"] and first["test_id"] and first["test_id"][-1].isalpha()
        if same:
            end = float(first["unix_end_printed_s"][:10])
            name = second["test_id"]
            figures.append(
                figure(
                    f"start {name}",
                    f"start of {name}",
                    printed(second["unix_start_printed_s"][:10], count=True),
                    Recomputed(end),
                    "s",
                    relation="at least",
                    why=f"before the end of {first['test_id']}",
                )
            )
    long = by(rows, "test_id")
    end_a, start_d = long["FL2-2a",]["unix_end_printed_s"], long["FL2-2d",]["unix_start_printed_s"]
    part = long["FL2-2c",]
    figures += [
        figure(
            "digits start",
            "start of FL2-2c, as printed",
            printed(part["unix_start_printed_s"], count=True),
            Recomputed(float(end_a) + 2.0, 2.0),
            "s",
        ),
        figure(
            "digits end",
            "end of FL2-2c, as printed",
            printed(part["unix_end_printed_s"], count=True),
            Recomputed(float(start_d) - 2.0, 2.0),
            "s",
        ),
    ]
    how = (
        "Each part of a test starts after the one before it ended (ten digits taken); FL2-2c continues FL2-2a "
        "and is continued by FL2-2d, 2 s apart."
    )
    return Section("stamps", "Appendix B, time stamps", how, tuple(figures), identity=True)


def _vacuum_runs(told: Told) -> Section:
    rows = by(table(DOC, "appendix_b1_thermal_tests"), "test_id")
    figures = []
    for i in range(1, 6):
        whole, cut = rows[f"Vac{i} Test",], rows[f"FL0-{i}",]
        after = Recomputed(float(cut["unix_start_printed_s"]) - float(whole["unix_start_printed_s"]))
        figures.append(figure(f"FL0-{i}", f"removed from the start of FL0-{i}", told["excluded_initial"], after, "s"))
    how = "Start of the run FL0 less start of the vacuum test that it is cut from."
    return Section("first 300 s", "Appendix B, first 300 s removed", how, tuple(figures))


def _rotations() -> Section:
    figures = []
    for row in table(DOC, "appendix_b2_rate_tests"):
        if row["purpose"].startswith("rate_transfer"):
            rate, first = float(row["rate_dps"]), row["purpose"].endswith("preliminary")
            dwell = (120.0 if rate < 0.005 else 60.0) if first else (260.0 if rate < 0.01 else 60.0)
            name = f"test {row['acs_id']}"
            found = Recomputed(rate * dwell)
            figures.append(figure(name, name, printed(row["rotation_deg"].lstrip("-"), count=True), found, "deg"))
    how = (
        "Rate times dwell: 60 s, and 260 s below 0.01 deg/s; in the preliminary series (tests 41 to 79) 120 s "
        "below 0.005 deg/s."
    )
    return Section("rotations", "Appendix B, angle turned", how, tuple(figures), identity=True)
