"""What many triads gave: parameters and covariance of each, how it went, and what is shown of all of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array, Component, Estimate
from ....core.remarks import Remark
from ....core.show.frames import frame
from ....core.show.result_tables import remarks_line
from ....core.show.rounding import near, number
from ....core.show.tables import Block, Table, html, text

if TYPE_CHECKING:
    from pandas import DataFrame


BY_LENGTH = 9  # parameters, where only the size of gravity is known
DIGITS = 3
SOURCE = "scatter between positions"

OK, FEW, NO_SCATTER, ILL_POSED, NOT_CONVERGED, OTHER_UNIT = range(6)
STATUS = (
    "estimated",
    "too few positions: fewer than parameters",
    "as many positions as parameters: no scatter, so no uncertainty",
    "the positions cannot tell all parameters apart",
    "the search did not settle",
    "the readings are not near gravity in size: another unit?",
)
CODES = ("", "too_few_positions", "no_scatter", "ill_posed", "not_converged", "unit_slip")
WAYS_OUT = (
    "",
    "Add positions",
    "Add positions, or give the scatter of a position",
    "Add positions with gravity between the axes",
    "Look at these readings for outliers",
    "Convert the readings to the unit of gravity",
)


@dataclass(frozen=True, eq=False)
class PositionsBatch:
    """Parameters of many triads with their covariance.

    Parameters
    ----------
    names, units : tuple of str, length k
        Parameters as ``sensors.terms`` names them, and their units.
    values : ndarray, shape (n, k)
        NaN where a unit has no estimate.
    covariance : ndarray, shape (n, k, k)
        NaN where it has none.
    squares : ndarray, shape (n,)
        Sum of squared residuals [unit of the readings squared].
    chi_square : ndarray, shape (n,)
        The same over the square of the scatter that was given; NaN where none was.
    dof : ndarray, shape (n,)
        Residuals less parameters.
    positions : ndarray, shape (n,)
        Positions without a missing reading.
    condition : ndarray, shape (n,)
        Of the Jacobian, in units of gravity: up to three times the ratio of its singular values.
    status : ndarray, shape (n,)
        Index into ``STATUS``.
    remarks : tuple of Remark
        Units without estimate or without uncertainty, counted by cause.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    covariance: Array
    squares: Array
    chi_square: Array
    dof: NDArray[np.int64]
    positions: NDArray[np.int64]
    condition: Array
    status: NDArray[np.int64]
    remarks: tuple[Remark, ...]
    _given: bool = False

    def __len__(self) -> int:
        return len(self.values)

    @property
    def u(self) -> Array:
        """Standard uncertainties, shape (n, k)."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))

    @property
    def words(self) -> tuple[str, ...]:
        """Status of each unit, in words."""
        return tuple(STATUS[one] for one in self.status)

    @property
    def estimated(self) -> NDArray[np.bool_]:
        """Which units have an estimate with an uncertainty, shape (n,)."""
        return np.asarray(self.status == OK)

    def estimate(self, unit: int) -> Estimate:
        """Return the parameters of one unit.

        Raises
        ------
        DataError
            If it has no estimate, or none with an uncertainty; with the code of its status.
        """
        status = int(self.status[unit])
        if status != OK:
            raise DataError(f"unit {unit}: {STATUS[status]}", do=WAYS_OUT[status], code=CODES[status])
        dof = np.inf if self._given else float(self.dof[unit]) / (1.0 if len(self.names) == BY_LENGTH else 3.0)
        component = Component(SOURCE, "A", self.covariance[unit], dof)
        return Estimate(self.names, self.values[unit], self.units, (component,))

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a unit: values, standard uncertainties and status."""
        found: dict[str, Any] = dict(zip(self.names, self.values.T, strict=True))
        found |= {f"u_{name}": u for name, u in zip(self.names, self.u.T, strict=True)}
        return frame(found | {"status": self.words})

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: of each parameter the median, how far units differ, and the median uncertainty."""
        good = self.estimated
        caption = f"{int(good.sum())} of {len(self)} units estimated"
        if not good.any():
            return (caption, *remarks_line(self.remarks))
        values, u = self.values[good], self.u[good]
        spread = values.std(axis=0, ddof=1) if len(values) > 1 else np.full(len(self.names), np.nan)
        columns = (np.median(values, axis=0), spread, np.median(u, axis=0))
        rows = [
            (
                name,
                near(float(columns[0][i]), float(columns[1][i])),
                *(number(float(c[i]), DIGITS) for c in columns[1:]),
                unit,
            )
            for i, (name, unit) in enumerate(zip(self.names, self.units, strict=True))
        ]
        heads = ("parameter", "median", "between units", "u (median)", "unit")
        return (Table(heads, rows, caption, (1, 2, 3)), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def remarks_of(status: NDArray[np.int64]) -> tuple[Remark, ...]:
    """Return the units without estimate or without uncertainty, counted by cause."""
    found = []
    for code in range(1, len(STATUS)):
        units = np.flatnonzero(status == code)
        if len(units):
            what = f"{len(units)} of {len(status)} unit(s) not estimated: {STATUS[code]}"
            found.append(Remark(CODES[code], "warning", what, f"unit {units[0]}", len(units), WAYS_OUT[code]))
    return tuple(found)
