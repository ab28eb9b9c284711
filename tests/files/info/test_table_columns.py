"""Which column of a reduced table is what, by its names alone."""

from __future__ import annotations

import numpy as np

from inertialcal.files.info.table_columns import guess
from inertialcal.files.text.table import Table


def test_a_lone_rate_in_german_is_the_tables_beside_a_reading_of_an_axis() -> None:
    found = guess(Table(("Drehrate [°/s]", "x [V]", "Temperatur [°C]"), ((),) * 3, np.empty(0, dtype=np.int64)))
    assert (found.applied, found.by_axis) == ("Drehrate [°/s]", {"x": "x [V]"})
    several = tuple(f"Drehrate {axis} [°/s]" for axis in "XYZ")
    assert guess(Table(several, ((),) * 3, np.empty(0, dtype=np.int64))).applied is None
    assert guess(Table(("Drehrate", "Temperatur"), ((),) * 2, np.empty(0, dtype=np.int64))).applied is None
    sollwert = ("Soll [°/s]", "Drehrate X [°/s]")
    assert guess(Table(sollwert, ((),) * 2, np.empty(0, dtype=np.int64))).applied == "Soll [°/s]"
