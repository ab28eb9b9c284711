"""Readings after earlier tests: what these found is taken off, and what is not known of it goes on into the figures.

A correction is taken off sample by sample. Its unknowns are common to all recordings of a test, and to every other test
that it was taken off (equal origins): they are no scatter, and more readings do not average them. A figure that is
linear in mean readings changes with them by its gain. The uncertainty of the correction so enters once, by these
unknowns, and what a constant does not change (a difference of readings, a scale factor) does not follow it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import permutations

import numpy as np

from ..core.errors import DataError
from ..core.estimate import Array, Component, Estimate
from ..core.key import AXES, Key, Origin
from ..core.recording import SECOND, Recording
from ..core.remarks import Remark
from ..core.unknowns import Unknowns
from .protocol import Correction

TakenOff = Mapping[Origin, Unknowns]  # by origin, a dwell a recording
NEGLIGIBLE = 0.01  # part of a change, below which a sensor does not count in degrees of freedom
SCALE, ACROSS = "scale_factor_error", "misalignment"
TINY = 1e-24  # of the largest eigenvalue of a covariance: no unknown of its own
LARGE = 0.5  # of the largest entry of a direction


def corrected(
    corrections: Sequence[Correction], named: Sequence[tuple[str, Recording]]
) -> tuple[list[Recording], list[TakenOff]]:
    """Return recordings after corrections, and the unknowns of what was taken off each.

    Parameters
    ----------
    corrections : sequence of Correction
        Each is taken off the recordings in its unit.
    named : sequence of (str, Recording)
        Each with its name: channels named by axis [SI], and what the corrections depend on.

    Raises
    ------
    DataError
        ``another_sensor`` if no recording is of the sensor of a correction; as the corrections say.
    """
    recordings: list[Recording] = [one for _, one in named]
    taken_off: list[dict[Origin, Unknowns]] = [{} for _ in named]
    for correction in corrections:
        own = [k for k, one in enumerate(recordings) if _unit(one) == correction.unit]
        if not own:
            units = ", ".join(dict.fromkeys(_unit(one) for one in recordings))
            what = f"after = {correction.test!r}, which found something in {correction.unit}; readings are in {units}"
            raise DataError(what, recordings[0].source.path, do="Leave out after", code="another_sensor")
        made, unknowns = correction.apply([(named[k][0], recordings[k]) for k in own])
        for k, recording, unknown in zip(own, made, unknowns, strict=True):
            recordings[k] = recording
            taken_off[k] |= unknown
    return recordings, list(taken_off)


def _unit(recording: Recording) -> str:
    return next((one.unit or "" for one in recording.channels if one.name in AXES), "")


def between(recording: Recording, start: int, stop: int) -> Recording:
    """Return the samples of a recording from one stamp to another, both included [ns]; without stamps, since its start.

    Parameters
    ----------
    recording : Recording
        With stamps, or a sample interval.
    start, stop : int
        [ns]
    """
    times = recording.time_ns
    if times is None:
        times = np.round(np.arange(len(recording)) * (recording.sample_interval or 1.0) * SECOND).astype(np.int64)
    keep = (times >= start) & (times <= stop)
    channels = tuple(replace(one, data=one.data[keep]) for one in recording.channels)
    return replace(recording, channels=channels, time_ns=times[keep])


def components(taken_off: TakenOff, keys: Sequence[Key], gain: Array) -> list[Component]:
    """Return what the unknowns of corrections change in figures that are linear in mean readings.

    Parameters
    ----------
    taken_off : mapping of Origin to Unknowns
        Of n dwells.
    keys : sequence of Key
        Of the figures.
    gain : ndarray, shape (k, n, 3)
        Figures per mean reading of x, y and z in each dwell.
    """
    found = []
    for origin, off in taken_off.items():
        changes = moved(off, gain)
        if np.any(changes):
            covariance = changes.T @ changes
            covariance = 0.5 * (covariance + covariance.T)
            dof = dof_of(off, gain)
            found.append(Component(origin, off.kind, covariance, dof, off.distribution, off.stated, changes,
                                   off.unknowns))  # fmt: skip
    return found


def moved(off: Unknowns, gain: Array) -> Array:
    """Return what each unknown changes in figures of a gain (k, n, 3) per mean reading, shape (s, k)."""
    return np.asarray(-np.einsum("sna,kna->sk", off.changes, gain))


def dof_of(off: Unknowns, gain: Array) -> Array:
    """Return the degrees of freedom of each figure, shape (k,): the fewest of the sensors that it rests on."""
    parts = np.sqrt(np.sum(np.einsum("sna,kna->ska", off.changes, gain) ** 2, axis=0))  # (k, 3)
    used = (parts > 0.0) & (parts >= NEGLIGIBLE * parts.max(axis=1, keepdims=True))
    return np.asarray(np.where(used, off.dof, np.inf).min(axis=1, initial=np.inf))


def found_by(estimate: Estimate, test: str) -> Estimate:
    """Return an estimate whose sources are unknowns of the test that found it, as other tests know them after it."""
    parts = []
    for one in estimate.components:
        origin = one.origin if one.origin.test else one.origin._replace(test=test)
        changes = factor(one.covariance) if one.changes is None else one.changes
        parts.append(replace(one, given=origin, changes=changes))
    return replace(estimate, components=tuple(parts))


def factor(covariance: Array) -> Array:
    """Return independent unknowns with this covariance, shape (s, n): ``changes.T @ changes`` is the covariance.

    Of the two directions of each, the one in which its first large entry is positive: rounding does not turn it.
    """
    return factors(covariance[None])[0]


def factors(covariances: Array) -> list[Array]:
    """Return the `factor` of each of several covariances, shape (u, n, n)."""
    scale = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    size = np.where(scale > 0.0, scale, 1.0)
    sizes, vectors = np.linalg.eigh(covariances / (size[:, :, None] * size[:, None]))
    keep = sizes > TINY * sizes[:, -1:]
    rows = (vectors * np.sqrt(np.where(keep, sizes, 0.0))[:, None]).swapaxes(1, 2)
    far = np.abs(rows)
    first = (far > LARGE * far.max(axis=2, keepdims=True)).argmax(axis=2)
    rows = np.copysign(1.0, np.take_along_axis(rows, first[..., None], axis=2)) * rows * size[:, None]
    return [own if kept.all() else own[kept] for own, kept in zip(rows, keep, strict=True)]


@dataclass(frozen=True, eq=False)
class MatrixCorrection:
    """Scale factors and misalignment that tests of a gyro found: their inverse makes rates of readings.

    Readings are those of the sensor less its bias, or with it: a bias is then found as the rate that looks like it, and
    `matrix` turns it back.

    Parameters
    ----------
    tests : tuple of str
        Their names.
    estimates : tuple of Estimate
        Of each: scale factor errors and misalignment alone.
    """

    tests: tuple[str, ...]
    estimates: tuple[Estimate, ...]

    @property
    def test(self) -> str:
        """Names of the tests."""
        return ", ".join(self.tests)

    @property
    def unit(self) -> str:
        """Of the readings."""
        return "rad/s"

    @property
    def reference_temperature(self) -> None:
        """None: no temperature matters."""
        return

    @property
    def keys(self) -> tuple[Key, ...]:
        """What the tests found, in order."""
        return tuple(key for one in self.estimates for key in one.keys)

    @property
    def matrix(self) -> Array:
        """Readings per rate, shape (3, 3): what no test found is that of an ideal sensor."""
        found = {key: float(value) for one in self.estimates for key, value in zip(one.keys, one.values, strict=True)}
        made = np.eye(3)
        for i, a in enumerate(AXES):
            made[i, i] += found.get(Key(SCALE, a), 0.0)
        for i, j in permutations(range(3), 2):
            made[i, j] = made[i, i] * found.get(Key(ACROSS, AXES[i] + AXES[j]), 0.0)
        return made

    def entries(self, law: Array) -> Array:
        """Return changes of the nine entries of the matrix, row by row, by changes of what was found (s, m): (s, 9)."""
        matrix, made = self.matrix, np.zeros((len(law), 3, 3))
        for change, key in zip(law.T, self.keys, strict=True):
            i = AXES.index(key.axis[0])
            if key.quantity == SCALE:
                made[:, i] += change[:, None] * matrix[i] / matrix[i, i]
            else:
                made[:, i, AXES.index(key.axis[1])] += matrix[i, i] * change
        return made.reshape(len(law), 9)

    def joined(self, other: MatrixCorrection) -> MatrixCorrection:
        """Return both as one.

        Raises
        ------
        DataError
            ``terms_twice`` if both found the same.
        """
        if twice := [str(key) for key in self.keys if key in other.keys]:
            what = f"after = {[*self.tests, *other.tests]}: both found {', '.join(twice)}"
            raise DataError(what, do="Leave one of them out", code="terms_twice")
        return MatrixCorrection((*self.tests, *other.tests), (*self.estimates, *other.estimates))

    def apply(
        self, recordings: Sequence[tuple[str, Recording]]
    ) -> tuple[list[Recording], list[Mapping[Origin, Unknowns]]]:
        """Return recordings of all three axes as rates, and what is not known of the matrix, at the mean of each.

        Raises
        ------
        DataError
            ``no_axes`` if a recording lacks an axis.
        """
        inverse, made, off = np.asarray(np.linalg.inv(self.matrix), dtype=float), [], []
        for name, one in recordings:
            if missing := [axis for axis in AXES if axis not in one.names]:
                what = (
                    f"no channel {', '.join(missing)}, and after = {self.test!r}, which found what axes read of others"
                )
                raise DataError(what, one.source.path or name, do="Leave out after", code="no_axes")
            rates = one.array(AXES) @ inverse.T
            channels = tuple(replace(c, data=rates[:, AXES.index(c.name)]) if c.name in AXES else c
                             for c in one.channels)  # fmt: skip
            made.append(replace(one, channels=channels))
            level = rates[np.isfinite(rates).all(axis=1)].mean(axis=0) if np.isfinite(rates).any() else np.zeros(3)
            off.append(self._unknowns(inverse, level))
        return made, list(off)

    def _unknowns(self, inverse: Array, level: Array) -> dict[Origin, Unknowns]:
        """Return what is not known, by origin: sources that several of the tests share are one."""
        laws: dict[Origin, tuple[Component, Array, Array]] = {}
        start, m = 0, len(self.keys)
        for test, estimate in zip(self.tests, self.estimates, strict=True):
            stop = start + len(estimate.keys)
            for one in found_by(estimate, test).components:
                if not np.any(one.u):
                    continue
                own, covariance = one.changes, one.covariance
                if own is None or one.term:  # changes by a term are those of a unit of it
                    own = factor(covariance)
                law, dof = np.zeros((len(own), m)), np.full(3, np.inf)
                law[:, start:stop] = own
                for key, free in zip(estimate.keys, np.broadcast_to(one.dof, len(estimate.keys)), strict=True):
                    i = AXES.index(key.axis[0])
                    dof[i] = min(dof[i], float(free))
                before = laws.get(one.origin)
                if before is not None and before[1].shape == law.shape:
                    law, dof = law + before[1], np.minimum(dof, before[2])
                origin = one.origin if before is None or before[1].shape == law.shape else (
                    one.origin._replace(test=test))  # fmt: skip
                laws[origin] = one, law, dof
            start = stop
        found = {}
        for origin, (one, law, dof) in laws.items():
            changes = (self.entries(law).reshape(-1, 3, 3) @ level) @ inverse.T
            found[origin] = Unknowns(origin, one.kind, changes[:, None, :], self.keys, law, dof, one.distribution,
                                     one.stated, one.unknowns)  # fmt: skip
        return found


@dataclass(frozen=True, eq=False)
class BiasCorrection:
    """A constant bias that a test found, to be taken off.

    Parameters
    ----------
    test : str
        Its name.
    estimate : Estimate
        Bias of each axis that has one, SI.
    temperature : mapping of str to float
        Of each axis meanwhile [degC]; without those not known.
    time : float or None
        Middle of its readings, since 1970 UTC [s]; None where they do not say it.
    recordings : tuple of str
        That it was found in.
    """

    test: str
    estimate: Estimate
    temperature: Mapping[str, float] = field(default_factory=dict[str, float])
    time: float | None = None
    recordings: tuple[str, ...] = ()

    @property
    def unit(self) -> str:
        """Of the readings."""
        return self.estimate.units[0]

    @property
    def reference_temperature(self) -> None:
        """None: the whole bias is taken off."""
        return

    def apply(
        self, recordings: Sequence[tuple[str, Recording]]
    ) -> tuple[list[Recording], list[Mapping[Origin, Unknowns]]]:
        """Return recordings with the bias taken off the axes that have one; the others are remarked."""
        bias = {key.axis: float(value) for key, value in zip(self.estimate.keys, self.estimate.values, strict=True)}
        made = []
        for name, one in recordings:
            channels = tuple(
                replace(c, data=np.asarray(c.data, dtype=np.float64) - bias[c.name]) if c.name in bias else c
                for c in one.channels
            )
            lacking = [c.name for c in one.channels if c.name in AXES and c.name not in bias]
            what = f"{self.test} found no bias of {', '.join(lacking)}: nothing is taken off"
            more = (Remark("no_bias", "warning", what, one.source.path or name),) if lacking else ()
            made.append(replace(one, channels=channels, remarks=(*one.remarks, *more)))
        unknowns = self._unknowns()
        return made, [unknowns for _ in made]

    def _unknowns(self) -> dict[Origin, Unknowns]:
        found, keys = {}, self.estimate.keys
        for one in found_by(self.estimate, self.test).components:
            law, origin = one.changes, one.origin
            if law is None or not np.any(one.u):
                continue
            changes, dof = np.zeros((len(law), 1, 3)), np.full(3, np.inf)
            for i, key in enumerate(keys):
                changes[:, 0, AXES.index(key.axis)] = law[:, i]
                dof[AXES.index(key.axis)] = np.broadcast_to(one.dof, len(keys))[i]
            found[origin] = Unknowns(origin, one.kind, changes, keys, law, dof, one.distribution, one.stated,
                                     one.unknowns)  # fmt: skip
        return found
