"""Mutants: small wrong changes to the numerics, each of which the tests of its folder must catch.

::

    python tests/mutants.py                       every mutant
    python tests/mutants.py --only statistics     those of a folder, a file, or with a number
    python tests/mutants.py --jobs 2              in two processes

A mutant names a file by its basename and a text that stands there once, so that a file may move without the list
being touched; the tests are named by their basenames too. Each is put into a copy of the tree, in which its tests are
run until one fails: ``caught``. ``LIVES`` asks for a test, of the physics or a closed form, never of a past output;
a mutant that changes nothing is taken out of the list. Tests that fail without a mutant are told and left out.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import IO, Any

ROOT = Path(__file__).resolve().parents[1]
SOURCE = Path("src") / "inertialcal"
AFTER = 2_000_000_000  # a time in the future [s]
LONGEST = 300  # of the tests of a mutant: one that never ends is caught [s]
THIRD_PARTY = (
    "numpy", "scipy.fft", "scipy.interpolate", "scipy.linalg", "scipy.optimize", "scipy.signal", "scipy.special",
    "scipy.stats", "scipy.spatial.transform", "numba", "pyarrow", "pyarrow.parquet", "h5py", "pydantic",
    "matplotlib.figure", "typer", "rich", "jinja2", "pandas",
)  # fmt: skip  # imported once, before the process forks


@cache
def sources(root: Path) -> dict[str, list[tuple[Path, str]]]:
    """Return paths and texts of the package, by basename."""
    found: dict[str, list[tuple[Path, str]]] = defaultdict(list)
    for path in sorted((root / SOURCE).rglob("*.py")):
        found[path.name].append((path, path.read_text(encoding="utf-8")))
    return found


@cache
def files_of_tests(root: Path) -> tuple[Path, ...]:
    """Return the test files."""
    return tuple(sorted((root / "tests").rglob("test_*.py")))


@dataclass(frozen=True)
class Mutant:
    """A text of a file, what takes its place, and the tests that must catch it."""

    file: str
    old: str
    new: str
    tests: str

    @property
    def words(self) -> str:
        """File and change, on one line."""
        return f"{self.file}: {' '.join(self.old.split())}  ->  {' '.join(self.new.split())}"

    def place(self, root: Path = ROOT) -> Path:
        """Return the file, relative to the root: the only one of its name in which the text stands, and once.

        Raises
        ------
        LookupError
            If there is none, or the text stands there or elsewhere again.
        """
        found = [(path, text.count(self.old)) for path, text in sources(root)[self.file]]
        at = [(path, count) for path, count in found if count]
        if len(at) != 1 or at[0][1] != 1:
            where = ", ".join(f"{path.relative_to(root)} ({count} x)" for path, count in at) or "nowhere"
            raise LookupError(f"{self.file}: {self.old!r} stands in {where}")
        return at[0][0].relative_to(root)

    def test_files(self, root: Path = ROOT) -> list[str]:
        """Return the test files, relative to the root.

        Raises
        ------
        LookupError
            If one is missing, or two have its name.
        """
        files = []
        for name in self.tests.split():
            found = [path for path in files_of_tests(root) if path.stem == name]
            if len(found) != 1:
                raise LookupError(f"{self.file}: {len(found)} files are called {name}.py")
            files.append(str(found[0].relative_to(root)))
        return files


MUTANTS = (
    Mutant("estimate.py", "total += component.covariance", "total -= component.covariance", "test_estimate"),
    Mutant(
        "estimate.py",
        "special.stdtrit(dof[acts], p) ** 2 - z_square",
        "special.stdtrit(dof[acts], p) - z_square",
        "test_estimate",
    ),
    Mutant("xsens.py", "-(2 ** (bits - 1))", "-(2**bits)", "test_lab_files"),
    Mutant("hobo.py", 'said[1] == "+" else', 'said[1] == "-" else', "test_lab_files"),
    Mutant("ulog.py", "astype(float) * 1e-6", "astype(float) * 1e-3", "test_lab_files"),
    Mutant("estimate.py", "np.maximum(1.0, 2.0 - FEW / dof)", "2.0", "test_estimate"),
    Mutant("conditions.py", "np.all(half <= WIDE * u)", "np.all(half >= WIDE * u)", "test_step_conditions"),
    Mutant("conditions.py", "1.0 - most) / (1.0 + most)", "1.0 - most)", "test_step_conditions"),
    Mutant("conditions.py", "for slow, likely in LIKELY.items()", "for slow, likely in ()", "test_step_conditions"),
    Mutant("conditions.py", "t_upper(LEVEL, count) * np", "WIDE * np", "test_step_conditions"),
    Mutant("as_run.py", 'found[: found.rfind(b"\\n") + 1]', "found", "test_sequenced_campaign"),
    Mutant("taken.py", "asked.monotonic_ns >= self._since", "asked.monotonic_ns < self._since", "test_step_ends"),
    Mutant(
        "estimate.py",
        "allowed = SYMMETRY * deviations[:, :, np.newaxis]",
        "allowed = 1e3 * SYMMETRY * deviations[:, :, np.newaxis]",
        "test_estimate",
    ),
    Mutant(
        "units.py",
        "zero, to_zero = (by_symbol()[unit[0][0]][0].offset for unit",
        "zero, to_zero = (0.0 for unit",
        "test_units",
    ),
    Mutant(
        "atoms.py",
        "return powers((*a, *((symbol, -exponent) for symbol, exponent in b)))",
        "return powers((*a, *((symbol, exponent) for symbol, exponent in b)))",
        "test_units",
    ),
    Mutant("atoms.py", "own * exponent) for symbol, own in a)", "own + exponent) for symbol, own in a)", "test_units"),
    Mutant("constants.py", "1.0 / 298.257223563", "1.0 / 298.257222101", "test_constants"),
    Mutant(
        "constants.py",
        "math.sqrt(2.0 * math.log(2.0) / math.pi)",
        "math.sqrt(math.log(2.0) / math.pi)",
        "test_constants",
    ),
    Mutant(
        "means.py",
        "np.sum(share**2 / np.broadcast_to",
        "np.sum(share / np.broadcast_to",
        "test_means",
    ),
    Mutant("means.py", "float(weights.sum() ** -0.5)", "float(weights.sum() ** -1.0)", "test_means"),
    Mutant("drift_line.py", "+ shared.T @ shared", "- 0.5 * shared.T @ shared", "test_drift_line"),
    Mutant("drift_line.py", "rank >= i for i", "rank > i for i", "test_drift_line"),
    Mutant("drift_line.py", "covariance = fixed + scaled", "covariance = scaled", "test_drift_line"),
    Mutant("drift_line.py", "special.stdtr(spare, -math.sqrt", "special.ndtr(-1e0 * math.sqrt", "test_drift_line"),
    Mutant("drift_line.py", "+ self.wander**2)", ")", "test_drift_line"),
    Mutant(
        "drift_line.py", "abs(level - value) + factor * u - limit", "abs(level) + factor * u - limit", "test_drift_line"
    ),
    Mutant("control_charts.py", "process**2 * (1.0 - 1.0 / n)", "0.0", "test_control_charts"),
    Mutant("control_charts.py", "- float(tests.mean())", "", "test_control_charts"),
    Mutant("control_charts.py", "length + 1 if one == side and one else 1", "length + 1", "test_control_charts"),
    Mutant("control_charts.py", "D2 = 2.0 / math.sqrt(math.pi)", "D2 = 1.0", "test_control_charts"),
    Mutant(
        "history.py",
        "if rejected:\n            words[i] = DEPARTURES",
        "if not rejected:\n            words[i] = DEPARTURES",
        "test_archive",
    ),
    Mutant("verify.py", "every[count - 1]", "every[-1]", "test_moves"),
    Mutant(
        "difference.py",
        "b.change(name) - a.change(name)",
        "b.change(name) + a.change(name)",
        "test_difference",
    ),
    Mutant(
        "difference.py",
        "(other.change - one.change) * max(one.size, other.size)",
        "(other.change - one.change) * one.size",
        "test_difference",
    ),
    Mutant(
        "difference.py",
        "self.u**2 - math.fsum(self.change(name) ** 2",
        "self.u**2 + math.fsum(self.change(name) ** 2",
        "test_difference",
    ),
    Mutant(
        "difference.py",
        "whole**2 / math.fsum(square**2 / dof",
        "whole / math.fsum(square**2 / dof",
        "test_difference",
    ),
    Mutant("decision.py", "elif ends(reject)[1] < low", "elif ends(reject)[1] <= low", "test_decision"),
    Mutant("decision.py", "if low <= lo and hi <= high:", "if low <= lo and hi < high:", "test_decision"),
    Mutant("decision.py", 'p if both or rule.name != "interval" else round(2.0 * p - 1.0, 12)', "p", "test_decision"),
    Mutant("decision.py", "alpha / (p.size - np.arange(p.size))", "alpha / (1 + np.arange(p.size))", "test_decision"),
    Mutant(
        "guard_band.py",
        "special.ndtr((lower + guard - true_value) / u)",
        "special.ndtr((lower - guard - true_value) / u)",
        "test_decision",
    ),
    Mutant(
        "least_squares.py",
        "dof = readings.size - len(labels)",
        "dof = readings.size - len(labels) + 1",
        "test_least_squares",
    ),
    Mutant(
        "least_squares.py",
        "lost = s <= s[..., :1] * max(white.shape[-2:]) * np.finfo(float).eps",
        "lost = s < 0.0 * s[..., :1]",
        "test_least_squares",
    ),
    Mutant(
        "least_squares.py",
        "np.sqrt(_checked_weights(weights, readings.size))",
        "_checked_weights(weights, readings.size)",
        "test_least_squares",
    ),
    Mutant(
        "least_squares.py",
        "rows.swapaxes(-1, -2) / s[..., None, :] / scale[..., None], length)",
        "rows.swapaxes(-1, -2) / s[..., None, :] / scale[..., None, :], length)",
        "test_least_squares",
    ),
    Mutant(
        "intervals.py",
        "return math.sqrt(dof / largest), ",
        "return math.sqrt(largest / dof), ",
        "test_intervals",
    ),
    Mutant(
        "intervals.py",
        "low = special.betaincinv(hits, n - hits + 1, tail)",
        "low = special.betaincinv(hits, n - hits, tail)",
        "test_intervals",
    ),
    Mutant("intervals.py", "coverage_factor(dof, p ** (1.0 / k))", "coverage_factor(dof, p ** k)", "test_intervals"),
    Mutant(
        "polynomial.py",
        "s = (2.0 * at - lo - hi) / (hi - lo)",
        "s = (2.0 * at - lo - hi) / (hi + lo)",
        "test_polynomial",
    ),
    Mutant(
        "polynomial.py",
        "covariance = None if self.covariance is None else change @ self.covariance @ change.T",
        "covariance = None if self.covariance is None else change.T @ self.covariance @ change",
        "test_polynomial",
    ),
    Mutant(
        "propagate.py",
        "np.subtract(ends(drawn.intervals[i]), ends(mine))",
        "np.add(ends(drawn.intervals[i]), ends(mine))",
        "test_propagate",
    ),
    Mutant(
        "propagate.py",
        "axis=0, ddof=1) / math.sqrt(blocks)",
        "axis=0, ddof=1)",
        "test_propagate",
    ),
    Mutant(
        "propagate.py",
        'float(f"5e{exponent - 1}")',
        'float(f"5e{exponent}")',
        "test_propagate",
    ),
    Mutant(
        "two_levels.py",
        "                free=n - p,",
        "                free=n,",
        "test_two_levels",
    ),
    Mutant(
        "_kernels_levels.py",
        "(drawn - total) / squares",
        "drawn / squares",
        "test_two_levels",
    ),
    Mutant(
        "two_levels.py",
        "return float(np.sqrt(2.0 / self.information))",
        "return float(np.sqrt(1.0 / self.information))",
        "test_two_levels",
    ),
    Mutant(
        "two_levels.py",
        "special.chdtri(dof, [0.025, 0.975])",
        "special.chdtri(dof + 3, [0.025, 0.975])",
        "test_two_levels",
    ),
    Mutant(
        "two_levels.py",
        "gain @ readings + bare @ (rows.T @ expected)",
        "gain @ readings - bare @ (rows.T @ expected)",
        "test_two_levels",
    ),
    Mutant(
        "_kernels_sphere.py",
        "rows[at, column] = own / stated[kind]",
        "rows[at, column] = own * stated[kind]",
        "test_positions_prior",
    ),
    Mutant(
        "prior.py",
        "max(1, round(found.information",
        "max(9, round(found.information",
        "test_positions_prior",
    ),
    Mutant(
        "slow_noise.py",
        "return (2.0 * _twice_integrated(lag) - ends) / length**2",
        "return (_twice_integrated(lag) - ends) / length**2",
        "test_slow_noise",
    ),
    Mutant(
        "slow_noise.py",
        "scale = np.array([2.0 * blocks.length, 1.0])",
        "scale = np.array([blocks.length, 1.0])",
        "test_slow_noise",
    ),
    Mutant(
        "slow_noise.py",
        "(2.0 * lag * lag * lag - ends) / (12.0 * length**2)",
        "(2.0 * lag * lag * lag - ends) / (6.0 * length**2)",
        "test_slow_noise",
    ),
    Mutant(
        "random_offsets.py",
        "return np.asarray(1.0 - 1.0 / np.sqrt(1.0 + ratio * total))",
        "return np.asarray(1.0 - 1.0 / (1.0 + ratio * total))",
        "test_random_offsets",
    ),
    Mutant(
        "random_offsets.py",
        "scaled - ((_part(total, ratio) / total)",
        "scaled + ((_part(total, ratio) / total)",
        "test_random_offsets",
    ),
    Mutant(
        "random_offsets.py",
        "sum(map(log, grown.tolist())) + log_design",
        "sum(map(log, grown.tolist())) - log_design",
        "test_random_offsets",
    ),
    Mutant("clustered.py", "1.0 / np.sqrt(np.maximum(left, ALONE)), 0.0)", "1.0, 0.0)", "test_clustered"),
    Mutant(
        "_kernels_levels.py",
        "own[k] * (own[k] - 2.0 * size[k])",
        "own[k] * (own[k] - size[k])",
        "test_clustered",
    ),
    Mutant("_kernels_levels.py", "far = 0.5 * (own - part[k])", "far = own - part[k]", "test_clustered"),
    Mutant(
        "scatters.py", "return min(2.0 * min(below, above), 1.0)", "return min(min(below, above), 1.0)", "test_scatters"
    ),
    Mutant(
        "scatters.py",
        "math.hypot(second - low_2, high_1 - first)",
        "math.hypot(second - low_2, first - low_1)",
        "test_scatters",
    ),
    Mutant(
        "quantiles.py",
        "np.asarray(dof) * f_upper(p, dof, np.inf)",
        "np.asarray(dof) * f_upper(p, np.inf, dof)",
        "test_quantiles",
    ),
    Mutant(
        "relation.py",
        "one[np.argmin(one[:, 1] - drift * one[:, 0])]",
        "one[np.argmin(one[:, 1] + drift * one[:, 0])]",
        "test_relation",
    ),
    Mutant("relation.py", "* (y - y0) > (y1 - y0) *", "* (y - y0) < (y1 - y0) *", "test_relation"),
    Mutant("relation.py", "np.minimum.outer(number, number) + 0.5", "np.eye(n) + 0.5", "test_relation"),
    Mutant("relation.py", "if tick else parts[:1]", "if not tick else parts[:1]", "test_relation"),
    Mutant("relation.py", "u = math.hypot(own, COMPUTER / math.sqrt(3.0))", "u = own", "test_relation"),
    Mutant(
        "rows.py",
        "power * standards[name].u for name, power",
        "standards[name].u for name, power",
        "test_recorded_clocks",
    ),
    Mutant("load.py", "worst = max(known, key", "worst = min(known, key", "test_recorded_clocks"),
    Mutant("drift.py", "rest, curve[-1] - curve[0]", "rest, curve[0] - curve[-1]", "test_drift"),
    Mutant("drift.py", "2.0 * special.stdtr(", "1.0 * special.stdtr(", "test_drift"),
    Mutant(
        "correlation.py",
        "length = fft.next_fast_len(n + lags, real=True)",
        "length = fft.next_fast_len(n, real=True)",
        "test_correlation",
    ),
    Mutant("correlation.py", "[x[: n - lag] @ y[lag:] for lag", "[x[lag:] @ y[: n - lag] for lag", "test_correlation"),
    Mutant(
        "held.py",
        "least = max(STUCK, LONGER * mean_run, 1.0 + np.log(CHANCE / n)",
        "least = max(STUCK, LONGER * mean_run, 1.0 + np.log(n / CHANCE)",
        "test_screening",
    ),
    Mutant("_kernels.py", "least = own if own < new else new", "least = new if own < new else own", "test_screening"),
    Mutant("codes.py", "before = read - step**2 / 12.0", "before = read - step**2 / 6.0", "test_codes"),
    Mutant(
        "_kernels.py",
        "d = np.float64(e[i] - a[i] + 3 * (b[i] - c[i]))",
        "d = np.float64(e[i] - a[i] + 3 * (c[i] - b[i]))",
        "test_allan_loops",
    ),
    Mutant(
        "_kernels.py",
        "for j in range(0, n - order * m, m):",
        "for j in range(0, n - order * m - 1, m):",
        "test_allan_loops",
    ),
    Mutant(
        "_kernels.py",
        "stop = starts * (part + 1) // parts",
        "stop = starts * (part + 1) // parts - 1",
        "test_allan_loops",
    ),
    Mutant("loops.py", "3: (-1, 3, -3, 1)", "3: (-1, 3, 3, 1)", "test_allan_published"),
    Mutant("autocovariance.py", "k * k - (i - shift) ** 2", "k * k + (i - shift) ** 2", "test_allan_edf"),
    Mutant("_kernels.py", "(steps[i] - r) / (steps[i] - ", "(r - steps[i]) / (steps[i] - ", "test_allan_loops"),
    Mutant(
        "edf.py", "exponent = BLUEST - power + 2 * modified", "exponent = BLUEST - power + modified", "test_allan_edf"
    ),
    Mutant("random_offsets.py", "- d * e * b * b", "+ d * e * b * b", "test_random_offsets"),
    Mutant("remembered.py", 'said += f"{one.dtype.str}{one.shape}"', "pass", "test_remembered"),
    Mutant(
        "random_offsets.py",
        "2.0 * sum(map(log, root)), float(last) ** 2",
        "1.0 * sum(map(log, root)), float(last) ** 2",
        "test_random_offsets",
    ),
    Mutant(
        "summaries.py",
        "0.5 * (parted[:, :half].max(axis=1) + upper)",
        "0.5 * (parted[:, :half].min(axis=1) + upper)",
        "test_batch_summaries",
    ),
    Mutant(
        "changes.py",
        "np.diff(first, append=len(values)) > 0",
        "np.diff(first, append=len(values)) > -1",
        "test_sine_changes",
    ),
    Mutant(
        "edf.py",
        "np.sqrt(known / special.chdtri(known, chance))[at]",
        "np.sqrt(special.chdtri(known, chance) / known)[at]",
        "test_allan_edf",
    ),
    Mutant(
        "gaps.py",
        "factor = np.sqrt(interval / averaging)",
        "factor = np.sqrt(averaging / interval)",
        "test_allan_dead_time",
    ),
    Mutant("psd.py", "2.0 * interval / (count * len(every))", "interval / (count * len(every))", "test_spectrum"),
    Mutant("_kernels_transform.py", "u - di, ui + d, turns", "u + di, ui + d, turns", "test_long_transform"),
    Mutant("_kernels_transform.py", "s2 * u - s1 * w, s2", "s2 * u + s1 * w, s2", "test_long_transform"),
    Mutant("_kernels_transform.py", "_set(y, o + 3 * to, u - wi", "_set(y, o + 3 * to, u + wi", "test_long_transform"),
    Mutant(
        "_kernels_transform.py",
        "for lane in range(start - row, LANES)",
        "for lane in range(LANES)",
        "test_long_transform",
    ),
    Mutant(
        "_kernels.py",
        "three + times(eight(weighted[at + 2])",
        "three + times(eight(weighted[at + 1])",
        "test_noise_covariance",
    ),
    Mutant("__init__.py", "if first >= 0 and first + n <= many", "if first >= 0", "test_batches"),
    Mutant("codes.py", "(high - low) / apart.min() > 2.0 * LEVELS", "(high - low) / apart.min() > 2e3", "test_codes"),
    Mutant("density.py", "edf = self.edf * size**2 / np.array", "edf = self.edf * size / np.array", "test_spectrum"),
    Mutant(
        "tapers.py",
        "return float(self.weights.shape[1] * len(sums) / sums.sum())",
        "return float(len(sums) / sums.sum())",
        "test_spectrum",
    ),
    Mutant(
        "amplitude.py",
        "chance = special.fdtrc(2.0, dof, 0.5 * ratio**2)",
        "chance = special.fdtrc(2.0, dof, ratio**2)",
        "test_sine",
    ),
    Mutant("amplitude.py", "np.where(ratio**2 > 2.0,", "np.where(ratio**2 > 4.0,", "test_sine"),
    Mutant(
        "level_changes.py",
        "0.5 - 0.5 * np.cos(np.pi * s",
        "0.5 + 0.5 * np.cos(np.pi * s",
        "test_turns",
    ),
    Mutant(
        "level_changes.py",
        "variance = max(float(rest @ rest) / n, 1e-300)",
        "variance = max(float(rest @ rest) / n, 1e-300) ** 0.5",
        "test_turns",
    ),
    Mutant(
        "level_changes.py",
        "likelihood = -0.5 * (n * np.log(variance) + logarithms)",
        "likelihood = -0.5 * (n * np.log(variance) - logarithms)",
        "test_turns",
    ),
    Mutant(
        "level_changes.py",
        "size.append((inverse @ one.beta)[:K])",
        "size.append(-(inverse @ one.beta)[:K])",
        "test_turns",
    ),
    Mutant(
        "level_changes.py",
        "covariance.append(one.variance * (inverse @ inverse.T)[:K, :K])",
        "covariance.append(one.variance * (inverse.T @ inverse)[:K, :K])",
        "test_turns",
    ),
    Mutant(
        "level_changes.py",
        "free = information - np.sum(score[:, 1:] ** 2, axis=1)\n        good",
        "free = information\n        good",
        "test_turns",
    ),
    Mutant(
        "level_changes.py",
        "gain -= n * np.log(np.maximum(1.0 - product",
        "gain += n * np.log(np.maximum(1.0 - product",
        "test_turns",
    ),
    Mutant(
        "level_changes.py",
        "free = fit.likelihood - sum(AT_SPIKE",
        "free = fit.likelihood + sum(AT_SPIKE",
        "test_turns",
    ),
    Mutant(
        "level_changes.py",
        "likely = np.exp(0.5 * (gain - gain.max()))",
        "likely = np.exp(-0.5 * (gain - gain.max()))",
        "test_turns",
    ),
    Mutant(
        "level_changes.py",
        "np.sqrt(one.variance / free)",
        "np.sqrt(one.variance * free)",
        "test_turns",
    ),
    Mutant(
        "fit.py",
        "return 2.0 * self.noise**2 * self.design.drive.step",
        "return self.noise**2 * self.design.drive.step",
        "test_sine",
    ),
    Mutant(
        "fit.py",
        "variance = share @ (each - value) ** 2 / (len(share) - 1.0)",
        "variance = share @ (each - value) ** 2 / len(share) ** 0.5",
        "test_sine",
    ),
    Mutant(
        "smooth.py",
        "np.exp(-0.5 * (np.subtract.outer(self.times, self.times) / length) ** 2)",
        "np.exp(-0.5 * (np.subtract.outer(self.times, self.times) * length) ** 2)",
        "test_sine",
    ),
    Mutant(
        "smooth.py",
        "np.linalg.norm(white[:, 0]) > DISTINCT",
        "np.linalg.norm(white[:, 0]) < DISTINCT",
        "test_sine",
    ),
    Mutant(
        "smooth.py",
        "DEGREE = 3  # of the polynomial",
        "DEGREE = 0  # of the polynomial",
        "test_sine",
    ),
    Mutant(
        "smooth.py",
        "linalg.cholesky(own + STRENGTH * self._kernel(length), lower=True)",
        "linalg.cholesky(own + 1e-4 * STRENGTH * self._kernel(length), lower=True)",
        "test_sine",
    ),
    Mutant(
        "smooth.py",
        "seen = np.column_stack([self.drift_basis, line / np.linalg.norm(self.line, axis=0)])",
        "seen = self.drift_basis",
        "test_sine",
    ),
    Mutant(
        "smooth.py",
        "return np.asarray(rest - left)",
        "return np.asarray(rest + left)",
        "test_sine test_mass_changes test_mass_drift test_mass_joining",
    ),
    Mutant(
        "noise.py",
        "each = self.level * ((1.0 - self.share) * white + self.share * walk / self.unit)",
        "each = self.level * ((1.0 - self.share) * white - self.share * walk / self.unit)",
        "test_sine",
    ),
    Mutant(
        "noise.py",
        "each = self.level * ((1.0 - self.share) * white + self.share * walk / self.unit)",
        "each = self.level * ((1.0 - self.share) * white + self.share * walk)",
        "test_sine",
    ),
    Mutant(
        "noise.py",
        "self.chance * (2.0 / self.dof * each**2 + (each - variance) ** 2)",
        "self.chance * (1.0 / self.dof * each**2 + (each - variance) ** 2)",
        "test_sine",
    ),
    Mutant(
        "noise.py",
        "(2.0 / self.dof * each**2 + (each - variance) ** 2)",
        "(2.0 / self.dof * each**2)",
        "test_sine",
    ),
    Mutant(
        "noise.py",
        "level = (1.0 / shape) @ squares / m",
        "level = (1.0 / shape) @ squares / (2.0 * m)",
        "test_sine",
    ),
    Mutant(
        "noise.py",
        "cost = 0.5 * (np.log(shape).sum(axis=1)[:, None] + m",
        "cost = 0.5 * (m",
        "test_sine",
    ),
    Mutant(
        "noise.py",
        "chance = before[:, None] * np.exp(cost.min(axis=0) - cost)",
        "chance = before[:, None] * np.exp(cost - cost.max(axis=0))",
        "test_sine",
    ),
    Mutant(
        "noise.py",
        "return bool(special.chdtrc(len(dof) - 1.0, statistic / correction) > UNEQUAL)",
        "return bool(special.chdtr(len(dof) - 1.0, statistic / correction) > UNEQUAL)",
        "test_sine test_mass_drift",
    ),
    Mutant(
        "_kernels.py",
        "return (c - b) - (d - a) / 3.0",
        "return (c - b) + (d - a) / 3.0",
        "test_sine_changes",
    ),
    Mutant(
        "changes.py",
        "found[k] = Jump(score, at, sign * size / STEP_PART)",
        "found[k] = Jump(score, at, sign * size * STEP_PART)",
        "test_sine_changes",
    ),
    Mutant(
        "changes.py",
        "np.median([0.5 * np.mean(np.diff(each) ** 2) for each in known])",
        "np.median([2.0 * np.mean(np.diff(each) ** 2) for each in known])",
        "test_sine_changes",
    ),
    Mutant(
        "changes.py",
        "inside = np.maximum(squares - k * before**2 - (m - k) * after**2, 0.0) / (m - 2.0)",
        "inside = np.maximum(squares - (m - k) * after**2, 0.0) / (m - 2.0)",
        "test_sine_changes",
    ),
    Mutant("drive.py", "+ self.step\n", "\n", "test_sine"),
    Mutant(
        "drive.py", "a * unit.quadrature - b * unit.in_phase", "a * unit.quadrature + b * unit.in_phase", "test_sine"
    ),
    Mutant(
        "reductions.py",
        "sums = running[i + wide + 1] - running[i - wide] - 0.5 *",
        "sums = running[i + wide + 1] - running[i - wide] - 1.0 *",
        "test_reductions",
    ),
    Mutant(
        "programme.py",
        "cosine[-1] *= 2.0\n    sine[-1] *= 2.0",
        "cosine[-1] *= 1.0\n    sine[-1] *= 2.0",
        "test_programme1969",
    ),
    Mutant(
        "programme.py",
        "amplitude * np.sin(2.0 * np.pi / samples_per_cycle * at)",
        "amplitude * np.cos(2.0 * np.pi / samples_per_cycle * at)",
        "test_programme1969",
    ),
    Mutant(
        "noise_scale.py",
        "np.sqrt(pooled), quiet * (BLOCK - 1)",
        "np.sqrt(pooled), quiet * BLOCK",
        "test_noise_scale",
    ),
    Mutant(
        "_kernels_levels.py",
        "different[block] = mean, squares / (size - 1), unequal",
        "different[block] = mean, squares / size, unequal",
        "test_noise_scale test_kernels_levels",
    ),
    Mutant(
        "_kernels_levels.py",
        "((e * e + f * f) + (g * g + h * h))) / 7.0, unequal",
        "((e * e + f * f) + (g * g + h * h))) / 8.0, unequal",
        "test_kernels_levels",
    ),
    Mutant(
        "_kernels_levels.py",
        "jumps[i] = share * abs(later[i] - sums[i])",
        "jumps[i] = share * abs(later[i] + sums[i])",
        "test_kernels_levels",
    ),
    Mutant(
        "_kernels_ramps.py",
        "level[high] - level[i] >= reversal",
        "level[high] - level[i] >= 2.0 * reversal",
        "test_ramps",
    ),
    Mutant(
        "samples.py",
        "hi[filled, column] = np.fmax.reduceat",
        "hi[filled, column] = np.fmin.reduceat",
        "test_decimation",
    ),
    Mutant(
        "schedule.py",
        "span = 2.0 * tolerance * (1.0 + ROUNDING)",
        "span = tolerance * (1.0 + ROUNDING)",
        "test_schedule",
    ),
    Mutant(
        "earth.py",
        "np.zeros_like(phi), -OMEGA * np.sin(phi)], axis=-1)",
        "np.zeros_like(phi), OMEGA * np.sin(phi)], axis=-1)",
        "test_earth",
    ),
    Mutant("earth.py", "[sa, -ca, 0.0]", "[-sa, ca, 0.0]", "test_earth"),
    Mutant("earth.py", "0.5 * amplitude**2]", "amplitude**2]", "test_earth"),
    Mutant("earth.py", "[c * x + s * y, c * y - s * x,", "[c * x - s * y, c * y + s * x,", "test_earth"),
    Mutant("earth.py", "+ 3.0 * (h / A) ** 2))", "- 3.0 * (h / A) ** 2))", "test_earth"),
    Mutant(
        "attitude.py",
        "C_reference_system: Array = R_z @ R_y @ R_x",
        "C_reference_system: Array = R_x @ R_y @ R_z",
        "test_attitude",
    ),
    Mutant(
        "_kernels.py",
        "slope[4] += v * x * z",
        "slope[4] += v * y * z",
        "test_attraction_bodies test_attraction_lattice",
    ),
    Mutant(
        "_kernels.py",
        "return -_angle(x, y, z, r), -_angle(y, z, x, r), -_angle(z, x, y, r), lx, ly, lz",
        "return -_angle(x, y, z, r), -_angle(y, z, x, r), -_angle(z, x, y, r), lx, lz, ly",
        "test_attraction_bodies test_attraction_lattice",
    ),
    Mutant(
        "extended.py",
        "np.sqrt(inner**2 + (outer**2 - inner**2) * (u + 1.0) / 2.0)",
        "inner + (outer - inner) * (u + 1.0) / 2.0",
        "test_attraction_bodies",
    ),
    Mutant(
        "bodies.py",
        "self.lower[i] + (at[i] + 0.5) * self.edges[i] for i",
        "self.lower[i] + at[i] * self.edges[i] for i",
        "test_attraction_lattice",
    ),
    Mutant("tilt.py", "line - moved[:, None, :]", "line + moved[:, None, :]", "test_tilt"),
    Mutant("content.py", "elif period[1] < last:", "elif period[1] > last:", "test_certificate"),
    Mutant("content.py", "if now != digest:", "if now and not digest:", "test_certificate"),
    Mutant(
        "content.py",
        "covariance = estimate.covariance[np.ix_(index, index)] * np.outer(scales, scales)",
        "covariance = estimate.covariance[np.ix_(index, index)] * scales",
        "test_dcc",
    ),
    Mutant("content.py", 'column([row["u"] for row in rows])', 'column([-row["u"] for row in rows])', "test_dcc"),
    Mutant("dcc.py", "figures.covariance[:, column]", "-figures.covariance[:, column]", "test_dcc"),
    Mutant("signature.py", "return VERIFIED, read", "return VERIFIED, xml", "test_certificate"),
    Mutant(
        "bound.py",
        '"sphere": (_sphere_volume, _sphere_field, 0.5)',
        '"sphere": (_sphere_volume, _sphere_field, 1.5)',
        "test_mass_shape",
    ),
    Mutant("bound.py", "0.8 * w**-0.5 + 0.2 * w**2 - 1.0", "0.8 * w**-0.5 + 0.4 * w**2 - 1.2", "test_mass_shape"),
    Mutant("cells.py", "((1.0, start), (-1.0, end))", "((1.0, start), (1.0, end))", "test_mass_shape"),
    Mutant("travel.py", "return float(np.ptp(self.fields) / 2.0)", "return float(np.ptp(self.fields))", "test_motion"),
    Mutant(
        "travel.py",
        "points = np.ascontiguousarray(-positions[:, None] * way)",
        "points = np.ascontiguousarray(positions[:, None] * way)",
        "test_motion",
    ),
    Mutant(
        "amplitude.py",
        "np.cross(field, axis) + np.cross(shifts, rows)",
        "np.cross(field, axis) - np.cross(shifts, rows)",
        "test_source_budget",
    ),
    Mutant("amplitude.py", "half = np.array([0.5, -0.5])", "half = np.array([0.5, 0.5])", "test_source_budget"),
    Mutant(
        "_kernels.py",
        "one = (0.5 - k) * mass[i] / (r_2 * math.sqrt(r_2))",
        "one = (1.0 - k) * mass[i] / (r_2 * math.sqrt(r_2))",
        "test_source_budget",
    ),
    Mutant("equation.py", "bent = (bent + coefficient) * away", "bent = bent * away + coefficient", "test_model"),
    Mutant(
        "equation.py",
        'np.exp(-columns["time"] / model.warm_up_time)',
        'np.exp(columns["time"] / model.warm_up_time)',
        "test_model",
    ),
    Mutant(
        "warm_up_model.py",
        "depends = _carried(means.start) > 1",
        "depends = _carried(means.start) <= 1",
        "test_warm_up_model",
    ),
    Mutant("warm_up_model.py", "gain = costs[1] - costs[2]", "gain = costs[2] - costs[1]", "test_warm_up_model"),
    Mutant(
        "warm_up_model.py",
        "left = means.readings[own] - curve - warm",
        "left = means.readings[own] + curve - warm",
        "test_warm_up_model",
    ),
    Mutant(
        "warm_up.py", "y - found.at(t, a, start), columns", "y + found.at(t, a, start), columns", "test_warm_up_model"
    ),
    Mutant("levels.py", "one[k] = 1.0", "one[k] = -1.0", "test_pressure_levels"),
    Mutant("levels.py", "ratio = s1 / s2", "ratio = s2 / s1", "test_pressure_levels"),
    Mutant("levels.py", "if top * float(p.min()) > LEVEL:", "if top * float(p.max()) > LEVEL:", "test_pressure_levels"),
    Mutant("against.py", "places - reference])", "places + reference])", "test_vacuum_step"),
    Mutant("against.py", "ratio = slope / step", "ratio = step / slope", "test_vacuum_step"),
    Mutant("against.py", "values - whole * (earth", "values + whole * (earth", "test_vacuum_step test_thermal_test"),
    Mutant("equation.py", ".transpose(2, 1, 0))", ".transpose(2, 0, 1))", "test_matrices"),
    Mutant(
        "equation.py",
        "change = (columns[one.channel] - one.reference)",
        "change = (columns[one.channel])",
        "test_compensate",
    ),
    Mutant("equation.py", "total = total + one.bias * away", "total = total - one.bias * away", "test_compensate"),
    Mutant(
        "equation.py",
        "one.bias_temperature * away * away_from_reference(model, columns)",
        'one.bias_temperature * away * columns["temperature"]',
        "test_compensate",
    ),
    Mutant(
        "uncertainty.py",
        "at.slope[:, sensor] * away * at.x[:, sensor]",
        "at.slope[:, sensor] * away * at.u[:, sensor]",
        "test_uncertainty",
    ),
    Mutant("uncertainty.py", "return away * at.away[:, sensor] if", "return at.away[:, sensor] if", "test_uncertainty"),
    Mutant(
        "compensate.py",
        "places[one.channel] = np.array(between)",
        "places[one.channel] = np.array([one.reference])",
        "test_compensate",
    ),
    Mutant(
        "nonlinearity.py",
        "2.0 * self.second + 3.0 * self.third * u",
        "2.0 * self.second + 2.0 * self.third * u",
        "test_nonlinearity",
    ),
    Mutant(
        "nonlinearity.py",
        "curvature = curve.second + 3.0 * curve.third * u",
        "curvature = curve.second + 1.5 * curve.third * u",
        "test_nonlinearity",
    ),
    Mutant(
        "uncertainty.py",
        "variance = variance + to_input**2 @ model.bias_run_to_run**2",
        "variance = variance + to_input**2 @ model.bias_run_to_run",
        "test_uncertainty",
    ),
    Mutant(
        "uncertainty.py", "np.exp(-time / tau) * time / tau**2", "np.exp(-time / tau) * time / tau", "test_uncertainty"
    ),
    Mutant("warm_up.py", "clusters = numbers if many else", "clusters = numbers if not many else", "test_warm_up"),
    Mutant(
        "warm_up.py",
        "self.time_constant * math.log(abs(self.change) / tolerance)\n\n",
        "self.time_constant * math.log10(abs(self.change) / tolerance)\n\n",
        "test_warm_up",
    ),
    Mutant(
        "conversion.py",
        'output = (volts["counts"] - above - zero_at_gains',
        'output = (volts["counts"] - above + zero_at_gains',
        "test_chain",
    ),
    Mutant(
        "conversion.py",
        "codes = np.rint((volts + above) / chain.step)",
        "codes = np.floor((volts + above) / chain.step)",
        "test_chain",
    ),
    Mutant(
        "converter.py",
        "return np.asarray((volts - self.voltage) / self.slope + self.temperature)",
        "return np.asarray((volts - self.voltage) / self.slope - self.temperature)",
        "test_chain",
    ),
    Mutant("model.py", "2.0 * np.eye(cross.shape[1]) - cross", "np.eye(cross.shape[1]) - cross", "test_ground_model"),
    Mutant(
        "expected.py",
        "10.0 * C(zero) - 15.0 * C(m) + 6.0 * C(2.0 * m) - C(3.0 * m)",
        "10.0 * C(zero) - 15.0 * C(m) + 6.0 * C(2.0 * m) + C(3.0 * m)",
        "test_noise_terms",
    ),
    Mutant(
        "expected.py",
        "weights = np.where(d == 0.0, m, 2.0 * (m - d))",
        "weights = np.where(d == 0.0, m, m - d)",
        "test_noise_terms",
    ),
    Mutant(
        "expected.py",
        "total = total + term.coefficient**2 / (np.pi * f)",
        "total = total + term.coefficient**2 / (2.0 * np.pi * f)",
        "test_noise_terms",
    ),
    Mutant(
        "terms.py",
        "np.cos(2.0 * np.pi * cycles * j) / (2.0 * np.sin(np.pi * cycles)) ** 2",
        "np.cos(2.0 * np.pi * cycles * j) / (2.0 * np.sin(2.0 * np.pi * cycles)) ** 2",
        "test_noise_terms",
    ),
    Mutant("terms.py", "duty**2 / (12.0 * far**2)", "duty**2 / (6.0 * far**2)", "test_noise_terms"),
    Mutant(
        "state_space.py",
        "np.array([[2.0 * variance / time]])",
        "np.array([[variance / time]])",
        "test_noise_state_space",
    ),
    Mutant(
        "state_space.py",
        "phi, qd = phi @ phi, phi @ qd @ phi.T + qd",
        "phi, qd = phi @ phi, phi.T @ qd @ phi + qd",
        "test_noise_state_space",
    ),
    Mutant(
        "to_filters.py",
        "spread = float(np.sqrt(0.5 * time)) if time",
        "spread = float(np.sqrt(time)) if time",
        "test_noise_to_filters",
    ),
    Mutant(
        "to_filters.py",
        "tuple(v / float(np.sqrt(step)) for v",
        "tuple(v * float(np.sqrt(step)) for v",
        "test_noise_to_filters",
    ),
    Mutant("_kernels.py", "row += sigma[t, r] * half[j, r]", "row += half[j, r]", "test_noise_fit"),
    Mutant(
        "_kernels.py",
        "= size - 2.0 * ends, ends, ends",
        "= size - ends, ends, ends",
        "test_noise_covariance",
    ),
    Mutant("_kernels_chain.py", "(1.0 - ninth)) / np.sqrt", "(1.0 - 0.5 * ninth)) / np.sqrt", "test_noise_fit"),
    Mutant(
        "likelihood.py",
        "fitted.powers[-1] * by / 0.1 * PER_E",
        "fitted.powers[-1] * by / 0.05 * PER_E",
        "test_noise_fit test_noise_covariance",
    ),
    Mutant(
        "simulate.py",
        "term.coefficient / np.sqrt(averaging), n)",
        "term.coefficient / averaging, n)",
        "test_noise_terms",
    ),
    Mutant(
        "planner.py",
        "tau * (1.0 + 0.5 / np.where(usable",
        "tau * (1.0 + 1.0 / np.where(usable",
        "test_noise_planner",
    ),
    Mutant(
        "blackman_tukey.py",
        "np.sqrt((2.0 if self.smoothed else 1.0) *",
        "np.sqrt((1.0 if self.smoothed else 2.0) *",
        "test_spectrum test_programme1969",
    ),
    Mutant("blackman_tukey.py", "twice[1:M] *= 2.0", "twice[1:] *= 2.0", "test_spectrum test_programme1969"),
    Mutant(
        "equations.py",
        "rank = int(np.sum(s > RELATIVE * s.max(initial=0.0)))",
        "rank = int(np.sum(s > -1.0))",
        "test_flip",
    ),
    Mutant("equations.py", "C = rotation(plan.axis, rows.angle)", "C = rotation(plan.axis, -rows.angle)", "test_flip"),
    Mutant(
        "equations.py",
        "return np.asarray(values - np.array([middle[axis] for axis in rows.axis]))",
        "return np.asarray(values)",
        "test_flip",
    ),
    Mutant(
        "uncertainty.py",
        "covariance = should_be_zero.T @ should_be_zero / count",
        "covariance = should_be_zero.T @ should_be_zero / (count - 1)",
        "test_flip_probabilities",
    ),
    Mutant(
        "uncertainty.py",
        "white = contrasts @ contrasts.T * (noise.white / (2.0 * record.length))",
        "white = contrasts @ contrasts.T * (noise.white / record.length)",
        "test_flip_noise test_flip_coverage",
    ),
    Mutant(
        "noise.py",
        "log = np.log(before / len(sizes)) - 0.5 * np.sum(np.log(whole), axis=1)",
        "log = np.log(before / len(sizes)) + 0.5 * np.sum(np.log(whole), axis=1)",
        "test_flip_noise",
    ),
    Mutant(
        "noise.py",
        "white = square / m\n",
        "white = square / (2.0 * m)\n",
        "test_flip_noise",
    ),
    Mutant(
        "noise.py",
        "rest = square[:, None] - fits * g**2",
        "rest = square[:, None] + fits * g**2",
        "test_flip_noise",
    ),
    Mutant(
        "noise.py",
        "own = log + np.log(NO_LINE) - 0.5 * m * np.log(square)",
        "own = log + np.log(NO_LINE) - m * np.log(square)",
        "test_flip_noise",
    ),
    Mutant(
        "noise.py",
        "a, b = (weights - float(weights @ root) * mean for weights in (one, other))",
        "a, b = (weights + float(weights @ root) * mean for weights in (one, other))",
        "test_flip_noise",
    ),
    Mutant(
        "noise.py",
        "turns = (np.cos(self.pieces.angle), np.sin(self.pieces.angle))",
        "turns = (np.ones(len(self.pieces.angle)), np.sin(self.pieces.angle))",
        "test_flip_noise",
    ),
    Mutant(
        "noise.py",
        "line = np.append(weights * p.root, -float(weights @ p.root))",
        "line = np.append(weights * p.root, float(weights @ p.root))",
        "test_flip_noise",
    ),
    Mutant(
        "noise.py",
        "turning = np.cos(np.subtract.outer(angle, angle))",
        "turning = -np.cos(np.subtract.outer(angle, angle))",
        "test_flip_noise",
    ),
    Mutant(
        "noise.py",
        "((fits * g) ** 2 + rest / m * fits).ravel()",
        "(rest / m * fits).ravel()",
        "test_flip_noise",
    ),
    Mutant(
        "noise.py",
        "shrunk = np.where(size > 0.0, u / np.where(size > 0.0, size, 1.0), 0.0)",
        "shrunk = np.where(size > 0.0, u, 0.0)",
        "test_flip_noise",
    ),
    Mutant(
        "pooling.py",
        "scatter = np.atleast_2d(np.cov(values, rowvar=False)) / len(used)",
        "scatter = np.atleast_2d(np.cov(values, rowvar=False))",
        "test_flip test_flip_coverage",
    ),
    Mutant(
        "pooling.py",
        "special.fdtrc(free, behind, square / free)",
        "special.fdtrc(free, behind, square)",
        "test_flip_probabilities",
    ),
    Mutant(
        "orbit.py",
        "predicted if plan.corrected else -predicted",
        "-predicted if plan.corrected else predicted",
        "test_flip_orbit",
    ),
    Mutant(
        "control.py",
        "2.0 * float(special.stdtr(min(dof, LARGEST), -abs(t)))",
        "float(special.stdtr(min(dof, LARGEST), abs(t)))",
        "test_flip_probabilities",
    ),
    Mutant(
        "regression.py",
        "weight = readings.samples[given] - 1.0",
        "weight = readings.samples[given] - 0.0",
        "test_rate_table_closed_forms",
    ),
    Mutant(
        "regression.py", "share = 1.0 - 1.0 / per_run if run.std is not None else 1.0", "share = 1.0", "test_rate_table"
    ),
    Mutant("turned.py", "columns.append(np.abs(x[sensor]))", "columns.append(x[sensor] ** 2)", "test_rate_table"),
    Mutant(
        "regression.py",
        "return np.asarray(y - times(stacked, row))",
        "return np.asarray(y + times(stacked, row))",
        "test_rate_table",
    ),
    Mutant(
        "regression.py",
        "dof_run = found.dof - dof\n",
        "dof_run = found.dof - dof + 1\n",
        "test_rate_table_closed_forms",
    ),
    Mutant(
        "rate_error.py",
        "read[np.isfinite(read)] / rate - 1.0",
        "1.0 - rate / read[np.isfinite(read)]",
        "test_rate_table",
    ),
    Mutant(
        "rate_error.py",
        "(_earth_variance(here, sensor) / rate**2, np.inf)",
        "(_earth_variance(here, sensor) / abs(rate), np.inf)",
        "test_rate_table_closed_forms",
    ),
    Mutant(
        "earth_input.py",
        "size = OMEGA * ROOT_THIRD\n        return",
        "size = OMEGA * ROOT_HALF\n        return",
        "test_rate_table",
    ),
    Mutant(
        "turned.py",
        "np.sum(beside**2, axis=1) - np.sum((beside @ basis) ** 2, axis=1)",
        "np.sum(beside**2, axis=1)",
        "test_rate_table_closed_forms",
    ),
    Mutant("linearity.py", "mean - (mean @ fit.design) @", "mean + (mean @ fit.design) @", "test_rate_table_offsets"),
    Mutant("linearity.py", " + between * in_groups", " + 0.0 * between * in_groups", "test_rate_table_offsets"),
    Mutant("linearity.py", "residuals - square * parts", "residuals", "test_rate_table_offsets"),
    Mutant("own_offsets.py", "starts) - 1.0 if seen", "starts) - 0.0 if seen", "test_rate_table_offsets"),
    Mutant("own_offsets.py", "1.0 / (size + between[..., None])", "1.0 / size", "test_rate_table_offsets"),
    Mutant("quantities.py", "size[:, None, None] ** 2 * (change", "0.0 * (change", "test_rate_table_offsets"),
    Mutant("regression.py", "1.0 / (within + dwell)", "1.0 + 0.0 * (within + dwell)", "test_rate_table_offsets"),
    Mutant(
        "closed_loop.py",
        "np.mean(delta * (2.0 * error - delta))),\n        float(np.sqrt(variance)),",
        "np.mean(delta * (error - delta))),\n        float(np.sqrt(variance)),",
        "test_closed_loop test_rate_table",
    ),
    Mutant(
        "closed_loop.py",
        "_p(one.gain + one.allowed, one)",
        "_p(one.gain - one.allowed, one)",
        "test_loop_verdicts",
    ),
    Mutant(
        "closed_loop.py",
        "shown = holm([p for _, _, p in tests], RISK * share / 2.0)",
        "shown = holm([p for _, _, p in tests], RISK * share)",
        "test_loop_verdicts",
    ),
    Mutant("closed_loop.py", "of_worse = 0.5 * share if any(", "of_worse = share if any(", "test_loop_verdicts"),
    Mutant(
        "closed_loop.py",
        "_p(-one.gain, one)",
        "_p(one.gain, one)",
        "test_loop_verdicts",
    ),
    Mutant(
        "closed_loop.py",
        "freedom = len(sums) / max(len(sums) - 1.0, 1.0)",
        "freedom = 1.0 / max(len(sums) - 1.0, 1.0)",
        "test_closed_loop",
    ),
    Mutant("_kernels_cells.py", "0.5 * path[u, i]", "path[u, i]", "test_thermal_law test_thermal_cells"),
    Mutant("_kernels_cells.py", "inner, part = -2.0 * own", "inner, part = -own", "test_thermal_cells"),
    Mutant("_kernels_cells.py", "0.5 * spread[u, i]", "spread[u, i]", "test_thermal_cells"),
    Mutant("_kernels_cells.py", "before * share * far * far", "before * far * far", "test_thermal_cells"),
    Mutant(
        "_kernels_cells.py",
        "square += left * left\n        along",
        "square += left\n        along",
        "test_thermal_cells",
    ),
    Mutant(
        "cells.py",
        "samples / np.maximum(samples - 2.0, 1.0)",
        "samples / np.maximum(samples - 1.0, 1.0)",
        "test_thermal_test test_thermal_law",
    ),
    Mutant(
        "cells.py",
        "weight = 1.0 / np.bincount(key)[key]",
        "weight = 1.0 * np.bincount(key)[key]",
        "test_thermal_law test_thermal_test",
    ),
    Mutant(
        "order.py",
        "@ found - 2.0 * held[own, p:])",
        "@ found - held[own, p:])",
        "test_thermal_law test_thermal_test",
    ),
    Mutant(
        "order.py",
        "np.argmax(scores <= NO_BETTER",
        "np.argmax(scores >= NO_BETTER",
        "test_thermal_law test_thermal_test",
    ),
    Mutant(
        "law.py",
        "np.asarray(-times(rows, slope) * (2.0",
        "np.asarray(times(rows, slope) * (2.0",
        "test_thermal_paths",
    ),
    Mutant(
        "cells.py",
        'flat["scatters"] ** 2 * flat["samples"]',
        'flat["scatters"] * flat["samples"]',
        "test_thermal_test",
    ),
    Mutant(
        "fixture.py",
        "design[i::3, 3 * i : 3 * i + 3] = force",
        "design[i::3, 3 * i : 3 * i + 3] = force[:, ::-1]",
        "test_positions_from_twins test_positions_labels",
    ),
    Mutant(
        "_kernels_fixture.py",
        "(axes[k, j, a] - direction[k, j] * tilt[k, a])",
        "(axes[k, j, a] + direction[k, j] * tilt[k, a])",
        "test_positions_fixture",
    ),
    Mutant(
        "_kernels_fixture.py",
        "(each[k, a] - tilt[k, a]) ** 2 + spread[2 * k + a, 2 * k + a])",
        "(each[k, a] - tilt[k, a]) ** 2)",
        "test_positions_fixture",
    ),
    Mutant(
        "_kernels_fixture.py",
        "turned[0, 3 * k + i, 3 * h + j] = same[k, h] * one",
        "turned[0, 3 * k + i, 3 * h + j] = one if k == h else 0.0",
        "test_positions_fixture",
    ),
    Mutant(
        "_kernels_components.py",
        "total -= moved[a, i, i]",
        "total += moved[a, i, i]",
        "test_variance_components",
    ),
    Mutant(
        "rotations.py",
        "u**2 * (float(one @ other) * np.eye(3) - np.outer(other, one))",
        "u**2 * (float(one @ other) * np.eye(3) + np.outer(other, one))",
        "test_positions_rotations test_positions_budget",
    ),
    Mutant(
        "accelerometer.py",
        "np.concatenate([-values[:9], np.zeros(3)]) * gravity.u",
        "np.concatenate([-values[:9], values[9:]]) * gravity.u",
        "test_positions_budget test_positions_propagation",
    ),
    Mutant(
        "accelerometer.py",
        "each = A[..., :, i, None] * A[..., None, j, :]",
        "each = A[..., i, :, None] * A[..., None, :, j]",
        "test_positions_sphere test_positions_propagation",
    ),
    Mutant(
        "accelerometer.py",
        "return np.asarray(np.sum((u @ T) ** 2 * inside, axis=-1))",
        "return np.asarray(np.sum((u @ T.swapaxes(-1, -2)) ** 2 * inside, axis=-1))",
        "test_positions_sphere test_positions_propagation test_positions_simulated",
    ),
    Mutant("gyro.py", "-np.kron(A, A.T)", "-np.kron(A.T, A)", "test_positions_propagation test_positions_rotations"),
    Mutant("gyro.py", "G = seen_g - earth if", "G = seen_g + earth if", "test_positions_earth_rate"),
    Mutant(
        "gyro.py",
        "variance = (inside + (acc.between or 0.0) ** 2) / local_gravity(plan) ** 2",
        "variance = inside / local_gravity(plan) ** 2",
        "test_positions_propagation test_positions_simulated test_positions_budget",
    ),
    Mutant("_kernels.py", "v1 = y1 * scale - m21 * v2", "v1 = y1 * scale + m21 * v2", "test_positions_batch"),
    Mutant(
        "_kernels.py",
        "j[3, k], j[4, k], j[5, k] = -v1 * y0, -v2 * y0, -v2 * y1",
        "j[3, k], j[4, k], j[5, k] = -v1 * y0, -v2 * y1, -v2 * y0",
        "test_positions_batch",
    ),
    Mutant(
        "at_rest.py",
        "mean_square = 1.0 / 3.0 if plan.latitude is None else 0.5 * np.cos(plan.latitude) ** 2",
        "mean_square = 1.0 / 3.0 if plan.latitude is None else np.cos(plan.latitude) ** 2",
        "test_positions_earth_rate",
    ),
    Mutant(
        "at_rest.py",
        "share = fit.chi_square / fit.free if",
        "share = fit.chi_square / (fit.free + 3) if",
        "test_positions_budget test_positions_levels test_positions_simulated",
    ),
    Mutant("design.py", "setup.pose**2 * (1.0 - u**2)", "setup.pose**2 * u**2", "test_positions_planning"),
    Mutant("rests.py", "_rows(readings, 0, len(readings) - 1)", "_rows(readings, 0, len(readings))", "test_guide"),
    Mutant("stream.py", "readings / self._scale.get", "readings * self._scale.get", "test_guided_session"),
    Mutant("session.py", "kept[first:stop] = False", "kept[stop:first] = False", "test_guided_session"),
    Mutant(
        "design.py",
        "common[:3] = setup.gravity_u / setup.gravity",
        "common[:3] = 0.5 * setup.gravity_u / setup.gravity",
        "test_positions_planning",
    ),
    Mutant(
        "rotations.py",
        "by_ends = -np.tensordot(gain,",
        "by_ends = np.tensordot(gain,",
        "test_positions_propagation test_positions_rotations",
    ),
    Mutant(
        "bands.py",
        "found += (1.0 if lag == 0 else 2.0) * each",
        "found += each",
        "test_microgravity",
    ),
    Mutant(
        "reduction.py",
        "noise, dof = np.sqrt(np.mean(bends**2, axis=0) / SECOND_DIFFERENCE)",
        "noise, dof = np.sqrt(np.mean(bends**2, axis=0) / 2.0)",
        "test_microgravity",
    ),
    Mutant(
        "scan.py",
        "part = np.partition(x, (off, n - off - 1), axis=1)",
        "part = x",
        "test_microgravity",
    ),
    Mutant(
        "model.py",
        "change = np.eye(len(keys)) - add @ taken",
        "change = np.eye(len(keys)) + add @ taken",
        "test_shifted_model",
    ),
    Mutant(
        "fit.py",
        "wanted = np.append(free, special",
        "wanted = np.append(flights, special",
        "test_shifted_model",
    ),
    Mutant(
        "fit.py",
        "over = WEIGHT @ special.ndtr(middle / deviations) > P",
        "over = np.mean(special.ndtr(middle / deviations), axis=0) > P",
        "test_small_launches",
    ),
    Mutant(
        "fit.py",
        "before[..., 0] = self._variances[:, None] * self.group",
        "before[..., 0] = 0.0 * self._variances[:, None] * self.group",
        "test_shifted_model",
    ),
    Mutant(
        "planning.py",
        "np.sum(np.square(each), axis=0)",
        "np.square(np.sum(each, axis=0))",
        "test_rate_table_plan",
    ),
    Mutant("planning.py", "line = line - line.sum() * record", "line = 1.0 * line", "test_flip_plan"),
    Mutant(
        "planned.py",
        "best.least * REACHED > figure.wanted",
        "best.u * REACHED > figure.wanted",
        "test_flip_plan",
    ),
    Mutant(
        "elements.py",
        "y * np.cos(angle) - x * np.sin(angle)",
        "y * np.cos(angle) + x * np.sin(angle)",
        "test_elements test_orbit_by_elements",
    ),
    Mutant(
        "reduction.py",
        "Estimate(found.keys, turn @ found.values",
        "Estimate(found.keys, 1.0 * found.values",
        "test_after_other_tests",
    ),
    Mutant(
        "solving.py",
        "return np.array([[c, s], [-s, c]])",
        "return np.array([[c, -s], [s, c]])",
        "test_alignment",
    ),
    Mutant(
        "reduction.py",
        "return widest >= 1.0 or widest * self.solution.rate > horizontal * math.sin(WIDEST)",
        "return widest >= 1.0",
        "test_alignment",
    ),
    Mutant(
        "contrasts.py",
        "weights = 1.0 / len(places) + inverse @ (wanted - middle)",
        "weights = 1.0 / len(places) - inverse @ (wanted - middle)",
        "test_heads",
    ),
    Mutant(
        "rigid.py",
        "return np.asarray(rate**2 * (3.0 * np.outer(vertical, vertical) - np.eye(3)))",
        "return np.asarray(rate**2 * (3.0 * np.outer(vertical, vertical) + np.eye(3)))",
        "test_heads test_heads_rig",
    ),
    Mutant(
        "reduction.py",
        "slopes[m, m] += q / (1.0 - q)",
        "slopes[m, m] -= q / (1.0 - q)",
        "test_heads",
    ),
    Mutant(
        "turned_mass.py",
        "common, tidal = w * w + 2.0 * orbit * w, 3.0 * orbit * orbit",
        "common, tidal = w * w - 2.0 * orbit * w, 3.0 * orbit * orbit",
        "test_turned_mass_physics",
    ),
    Mutant(
        "joining.py",
        "read[0] -= towards * arm",
        "read[0] += towards * arm",
        "test_turned_mass",
    ),
    Mutant(
        "response.py",
        "passed[k] * wave(k * angle)",
        "wave(k * angle)",
        "test_turned_mass",
    ),
    Mutant(
        "reduction.py",
        "tilt = 0.5 * ROOT_3 * plan.alignment**2 * relative",
        "tilt = 0.5 * ROOT_3 * plan.alignment * relative",
        "test_turned_mass",
    ),
    Mutant(
        "joining.py",
        "order.append((2 * k, np.array([[c, s], [s, -c]])))",
        "order.append((2 * k, np.array([[c, s], [-s, c]])))",
        "test_turned_mass",
    ),
    Mutant(
        "response.py",
        "share = applied / (applied + G * tau)",
        "share = applied / (applied - G * tau)",
        "test_mass_attraction",
    ),
    Mutant(
        "response.py",
        "u = float(np.hypot(u, u_p * tau))",
        "u = float(np.hypot(u, 2.0 * u_p * tau))",
        "test_mass_attraction",
    ),
    Mutant(
        "response.py",
        "RAYLEIGH = float(np.sqrt(np.pi / 2.0))",
        "RAYLEIGH = float(np.sqrt(np.pi))",
        "test_mass_attraction test_reinel1969",
    ),
    Mutant(
        "joining.py",
        "fit.covariance[0, 0] * fit.squares / spare",
        "fit.covariance[0, 0] * fit.squares / len(values)",
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        'return "between_runs" if wide[1] >= wide[0] else "within_runs"',
        'return "between_runs" if wide[1] < wide[0] else "within_runs"',
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        "share = -cotangent * sign if",
        "share = cotangent * sign if",
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        "cotangent = float(1.0 / np.tan(0.5 * starts.sum()))",
        "cotangent = float(1.0 / np.tan(starts.sum()))",
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        "columns = np.column_stack([ones, np.cos(ahead), np.sin(ahead)])",
        "columns = np.column_stack([ones, np.cos(ahead), np.cos(ahead) ** 2])",
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        "w = 1.0 / (u**2 + t_2)",
        "w = 1.0 / (u + t_2)",
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        "wanted = 2.0 * float(special.gammaincinv(",
        "wanted = float(special.gammaincinv(",
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        "float(parts.sum() ** 2 / np.sum(parts**2 / dof))",
        "float(parts.sum() ** 2 / np.sum(parts**2) / dof.sum())",
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        "(1.0 + float(np.max(share**2)))",
        "(1.0 - float(np.max(share**2)))",
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        "reading=run.reading - common_part - at_drive",
        "reading=run.reading + common_part - at_drive",
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        "amplitude, quadrature = found.amplitude + self.line.real, found.quadrature + self.line.imag",
        "amplitude, quadrature = found.amplitude - self.line.real, found.quadrature + self.line.imag",
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        "* np.sqrt(self.m / (self.m - 1.0))",
        "* np.sqrt((self.m - 1.0) / self.m)",
        "test_mass_joining",
    ),
    Mutant(
        "joining.py",
        "sizes = own.sizes * (2.0 if len(runs) == 2 else 1.0)",
        "sizes = own.sizes",
        "test_mass_joining",
    ),
    Mutant(
        "tilt.py",
        "return run.reading - p * tilt, p, 0.0, 0.0",
        "return run.reading + p * tilt, p, 0.0, 0.0",
        "test_mass_attraction",
    ),
    Mutant(
        "tilt.py",
        "return x / (run.schedule.amplitude + sign * G * tau)",
        "return x / (run.schedule.amplitude - sign * G * tau)",
        "test_mass_attraction",
    ),
    Mutant(
        "tilt.py",
        "0.5 * (most - size)) if most > size",
        "0.5 * (most + size)) if most > size",
        "test_mass_attraction",
    ),
    Mutant(
        "tilt.py",
        "return np.asarray(plan.tilt_sign * (tilt - middle))",
        "return np.asarray(tilt - middle)",
        "test_mass_attraction",
    ),
    Mutant(
        "tilt.py",
        "tilt = tilt - (computed if",
        "tilt = tilt + (computed if",
        "test_mass_attraction",
    ),
    Mutant(
        "tilt.py",
        "abs(found.value) < CLEAR * found.u",
        "abs(found.value) > CLEAR * found.u",
        "test_mass_attraction",
    ),
    Mutant(
        "response.py",
        "/ float(np.sqrt(2.0)) / max(sum(one.moved",
        "/ 2.0 / max(sum(one.moved",
        "test_mass_attraction",
    ),
    Mutant(
        "changes.py",
        "return Regression(xy / yy,",
        "return Regression(xy / xx,",
        "test_mass_attraction",
    ),
    Mutant(
        "changes.py",
        "float(np.sqrt(left / max(dof, 1.0) / yy))",
        "float(np.sqrt(left / yy))",
        "test_mass_attraction",
    ),
    Mutant(
        "changes.py",
        "walk = np.minimum(here[:, None], here[None, :]) - t[0] + 1.0",
        "walk = np.maximum(here[:, None], here[None, :]) - t[0] + 1.0",
        "test_mass_changes",
    ),
    Mutant(
        "changes.py",
        "[ends, s[:-d]] if d > 0",
        "[s[d:], ends] if d > 0",
        "test_mass_changes test_mass_attraction",
    ),
    Mutant(
        "line.py",
        "return np.asarray((schedule.applied - middle) / schedule.amplitude)",
        "return np.asarray((middle - schedule.applied) / schedule.amplitude)",
        "test_mass_attraction",
    ),
    Mutant(
        "joining.py",
        "own[-1] = plan.high_g.u * found.value / plan.high_g.scale_factor**2",
        "own[-1] = plan.high_g.u / plan.high_g.scale_factor**2",
        "test_mass_attraction test_reinel1969",
    ),
    Mutant(
        "joining.py",
        'slopes, units = [*slopes, 1.0 / plan.nominal], [*units, "1"]',
        'slopes, units = [*slopes, plan.nominal], [*units, "1"]',
        "test_mass_attraction",
    ),
    Mutant(
        "forecast.py",
        "C[:-4] - 4.0 * C[1:-3] + 6.0 * C[2:-2] - 4.0 * C[3:-1] + C[4:]",
        "C[:-4] - 4.0 * C[1:-3] + 6.0 * C[2:-2] - 4.0 * C[3:-1] - C[4:]",
        "test_mass_forecast",
    ),
    Mutant(
        "forecast.py",
        "wanted = math.sqrt(target**2 - u_applied**2)",
        "wanted = math.sqrt(target**2 + u_applied**2)",
        "test_mass_forecast",
    ),
    Mutant(
        "rows.py",
        "distance = (2.0 * pull / gradient) ** (1.0 / 3.0)",
        "distance = (pull / gradient) ** (1.0 / 3.0)",
        "test_plan_mass_attraction test_plan_proof_mass",
    ),
    Mutant(
        "inputs.py",
        "late = 2.0 * np.pi * float(times[there][0] - times[0]) / period",
        "late = -2.0 * np.pi * float(times[there][0] - times[0]) / period",
        "test_sine_command",
    ),
    Mutant(
        "reduction.py",
        "dof = dof * (total / own) ** 4",
        "dof = dof * (own / total) ** 4",
        "test_sine_command",
    ),
    Mutant("rows.py", "float(np.hypot(row.u, own * row.value))", "float(row.u + own * row.value)", "test_static_noise"),
    Mutant(
        "rows.py", "covariance = np.outer(changes, changes)", "covariance = np.diag(changes**2)", "test_static_noise"
    ),
    Mutant(
        "filtered.py",
        "(windows(m) * (1.0 - band.share)).T",
        "(windows(m) * (1.0 + band.share)).T",
        "test_filtered test_band",
    ),
    Mutant(
        "filtered.py",
        "return np.asarray(4.0 * (0.5 / GRID) * fourth",
        "return np.asarray(2.0 * (0.5 / GRID) * fourth",
        "test_filtered test_band",
    ),
    Mutant(
        "filtered.py",
        "1.0 + (self.passed[0] - 1.0) * (cycles / low) ** 2",
        "1.0 - (self.passed[0] - 1.0) * (cycles / low) ** 2",
        "test_filtered test_band",
    ),
    Mutant(
        "filtered.py",
        "a = 1.0 + 0.5 / size",
        "a = 1.0 + 2.0 / size",
        "test_filtered test_band",
    ),
    Mutant(
        "filtered.py",
        "return np.asarray((1.0 + 0.5 * curve * part**2) ** -2)",
        "return np.asarray((1.0 - 0.5 * curve * part**2) ** -2)",
        "test_filtered test_band",
    ),
    Mutant(
        "filtered.py",
        "np.exp(np.interp(-np.log(0.5), [-a, -b]",
        "np.exp(np.interp(-np.log(0.25), [-a, -b]",
        "test_filtered test_band",
    ),
    Mutant(
        "filtered.py",
        "gains.append((2.0 * (alone - cost), CORNERS",
        "gains.append((-2.0 * (alone - cost), CORNERS",
        "test_filtered test_band",
    ),
    Mutant(
        "_kernels.py",
        "level += powers[i] * parts[i, t, 1]",
        "level += 0.0 * parts[i, t, 1]",
        "test_filtered test_band",
    ),
    Mutant(
        "filtered.py",
        "H = (slopes.T * (measured / mu**2)) @ slopes",
        "H = (slopes.T * (measured / mu)) @ slopes",
        "test_filtered test_band",
    ),
    Mutant(
        "filtered.py",
        "max(1, int(np.ceil(PERIODS / self.corner)))",
        "max(1, int(np.ceil(0.1 * PERIODS / self.corner)))",
        "test_filtered test_band",
    ),
    Mutant(
        "limits.py",
        "return float(special.ndtri(0.5 * (1.0 + p)))",
        "return float(special.ndtri(p))",
        "test_noise_fit test_noise_limits",
    ),
    Mutant(
        "_kernels.py",
        "np.sqrt(max(2.0 * rise, 0.0) / stretch)",
        "np.sqrt(max(rise, 0.0) / stretch)",
        "test_noise_fit test_noise_limits",
    ),
    Mutant(
        "_kernels.py",
        "chance = math.erfc(far * HALF_ROOT)",
        "chance = math.erfc(-far * HALF_ROOT)",
        "test_noise_fit test_noise_limits",
    ),
    Mutant(
        "limits.py",
        "octave - back, 0)] * 2.0 ** (more - back)",
        "octave - back, 0)]",
        "test_noise_fit test_noise_limits",
    ),
    Mutant(
        "_kernels.py",
        "min(max(2.0 * (cost - least), 0.0), most)",
        "min(max(0.5 * (cost - least), 0.0), most)",
        "test_noise_fit test_noise_rivals test_noise_limits",
    ),
    Mutant(
        "_kernels.py",
        "a, b = (value, value) if way == TIME",
        "a, b = (start, start) if way == TIME",
        "test_noise_fit test_noise_rivals test_noise_limits",
    ),
    Mutant(
        "_kernels.py",
        "(cost - least), 0.0), most)) - root",
        "(cost - least), 0.0), most)) + root",
        "test_noise_fit test_noise_limits",
    ),
    Mutant("noise.py", "power[1:half] *= 0.5", "power[1:half] *= 1.0", "test_flicker"),
    Mutant(
        "noise.py",
        "weights = ((-2, 1.0), (-1, -4.0), (0, 6.0)",
        "weights = ((-2, 1.0), (-1, -4.0), (0, 5.0)",
        "test_flicker",
    ),
    Mutant(
        "noise.py",
        "start = np.cumsum(inside + between, axis=0) - inside - between",
        "start = np.cumsum(inside + between, axis=0) - inside",
        "test_still_gyro_rig test_rate_table_rig test_flicker",
    ),
    Mutant(
        "gyro_bench.py",
        "0.5 * (rates[1:] + rates[:-1]) * np.diff(knots)",
        "rates[1:] * np.diff(knots)",
        "test_rate_table_rig",
    ),
    Mutant(
        "gyro_bench.py",
        "turn[j], turn[k] = -angles[1], angles[0]",
        "turn[j], turn[k] = angles[1], angles[0]",
        "test_rate_table_rig",
    ),
    Mutant(
        "head_turn.py",
        "np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * side",
        "np.cos(angle)[:, None] * across - np.sin(angle)[:, None] * side",
        "test_head_turn",
    ),
    Mutant(
        "head_turn.py",
        "np.multiply.outer(motion.rate**2, np.cross(along, np.cross(along, arm)))",
        "np.multiply.outer(motion.rate, np.cross(along, np.cross(along, arm)))",
        "test_head_turn",
    ),
    Mutant(
        "motion.py",
        "tilt = -np.arctan2(np.linalg.norm(cross), cosine)",
        "tilt = np.arctan2(np.linalg.norm(cross), cosine)",
        "test_hand_held_rig",
    ),
    Mutant(
        "record.py", "white *= density * np.sqrt(0.5 * rate)", "white *= density * np.sqrt(rate)", "test_sams_tsh_rig"
    ),
    Mutant(
        "screening.py",
        "_beyond(one, known.upto - begin)",
        "_beyond(one, 0)",
        "test_lab_screening",
    ),
    Mutant(
        "recorded.py",
        "if axis is None or not len(axis.gaps):\n        return None\n    steps",
        "if axis is None:\n        return None\n    steps",
        "test_recorded",
    ),
    Mutant(
        "live.py",
        "(self.count - count) % self._kept]) if",
        "(self.count - count - 1) % self._kept]) if",
        "test_acquisition",
    ),
)


def main() -> int:
    """Run the mutants, and tell those that live."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--only", default="", help="folder, file, part of a text, or numbers with commas between")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--unchecked", action="store_true", help="do not run the tests without a mutant first")
    parser.add_argument("--work", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.work:
        return work(given.work)
    if re.fullmatch(r"[\d,]+", given.only):
        chosen = [int(number) for number in given.only.split(",")]
    else:
        chosen = [number for number, mutant in enumerate(MUTANTS) if wanted(mutant, given.only)]
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        return run(chosen, Path(folder), given.jobs, given.unchecked)


def wanted(mutant: Mutant, only: str) -> bool:
    """Return whether a mutant is asked for by a folder, a file or a text."""
    return not only or only in mutant.words or only in mutant.place().parts


def run(chosen: Sequence[int], folder: Path, jobs: int, unchecked: bool = False) -> int:
    """Run mutants in copies of the tree; 0 if each is caught."""
    workers = [Worker(folder / str(k)) for k in range(jobs)]
    begin = time.monotonic()
    broken: list[str] = []
    if not unchecked:
        copy = workers[0].folder
        broken = workers[0].broken(sorted({file for number in chosen for file in MUTANTS[number].test_files(copy)}))
        for name in broken:
            print(f"FAILS WITHOUT A MUTANT, left out: {name}", flush=True)
    found: dict[int, str] = {}
    free = list(workers)

    def one(number: int) -> None:
        worker = free.pop()
        found[number] = worker.verdict(number, broken)
        free.append(worker)
        print(f"{number:4d} {found[number]:60s} {MUTANTS[number].words}", flush=True)

    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(one, chosen))
    for worker in workers:
        worker.close()
    alive = [number for number in chosen if not found[number].startswith("caught")]
    print(f"{len(chosen)} mutants, {len(chosen) - len(alive)} caught, in {time.monotonic() - begin:.0f} s")
    for number in alive:
        print(f"{found[number]}: {number} {MUTANTS[number].words}")
    return 1 if alive else 0


class Worker:
    """A copy of the tree and a process that runs tests in it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        nothing = shutil.ignore_patterns(".hypothesis", "out")
        for name in ("src", "tests"):
            shutil.copytree(ROOT / name, folder / name, ignore=nothing)
        shutil.copy(ROOT / "pyproject.toml", folder)
        environment = os.environ | {
            "PYTHONPATH": str(folder / "src"), "PYTHONDONTWRITEBYTECODE": "", "OMP_NUM_THREADS": "1",
            "INERTIALCAL_SHARED": os.environ.get("INERTIALCAL_SHARED", str(ROOT.parent / "shared")),
        }  # fmt: skip
        command = [sys.executable, __file__, "--work", str(folder)]
        self.process = subprocess.Popen(
            command, cwd=folder, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def ask(self, question: dict[str, Any]) -> dict[str, Any]:
        """Return what the process answers."""
        to, back = self.process.stdin, self.process.stdout
        assert to is not None
        assert back is not None
        to.write(json.dumps(question) + "\n")
        to.flush()
        answer: dict[str, Any] = json.loads(back.readline())
        return answer

    def broken(self, files: list[str]) -> list[str]:
        """Return the tests that fail as the tree is."""
        failed: list[str] = self.ask({"files": files, "all": True, "longest": 100 * LONGEST, "without": []})["failed"]
        return failed

    def verdict(self, number: int, broken: Sequence[str] = ()) -> str:
        """Put a mutant in, run its tests, and take it out."""
        mutant = MUTANTS[number]
        place, files = mutant.place(self.folder), mutant.test_files(self.folder)
        target = self.folder / place
        text, before = target.read_text(encoding="utf-8"), target.stat()
        target.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
        os.utime(target, (AFTER + number, AFTER + number))  # no compiled file is of this one
        cache = self.folder / "compiled" if place.name.startswith("_kernels") else None
        answer = self.ask(
            {
                "files": files,
                "all": False,
                "longest": LONGEST,
                "compiled": str(cache or ""),
                "without": broken,
            }
        )
        target.write_text(text, encoding="utf-8")
        os.utime(target, ns=(before.st_atime_ns, before.st_mtime_ns))
        if cache is not None:
            shutil.rmtree(cache, ignore_errors=True)
        failed = answer["failed"]
        status = answer["status"]
        if status == "late":
            return "caught: never ends"
        if status == 0:
            return "LIVES"
        if status == 1 and failed:
            path, _, name = failed[0].partition("::")
            return f"caught by {Path(path).name}::{name}"
        return f"NO VERDICT (pytest {status})"

    def close(self) -> None:
        """Let the process end."""
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                pipe.close()
        self.process.wait()


# In the process of a worker


def work(folder: Path) -> int:
    """Answer questions: run test files in a fork, in which nothing of the package is imported yet."""
    import importlib

    for name in THIRD_PARTY:
        importlib.import_module(name)
    for line in sys.stdin:
        question = json.loads(line)
        told = folder / "told.txt"
        with told.open("w", encoding="utf-8") as output:
            status = forked(question, output)
        text = told.read_text(encoding="utf-8", errors="replace")
        failed = re.findall(r"^(?:FAILED|ERROR) (\S+)", text, re.MULTILINE)
        print(json.dumps({"status": status, "failed": failed}), flush=True)
    return 0


def forked(question: dict[str, Any], output: IO[str]) -> int | str:
    """Run pytest in a fork; return its exit status, or ``late``."""
    child = os.fork()
    if not child:
        os.setpgid(0, 0)
        os.dup2(output.fileno(), 1)
        os.dup2(output.fileno(), 2)
        os._exit(tested(question))
    end = time.monotonic() + float(question["longest"])
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.05)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return "late"


def tested(question: dict[str, Any]) -> int:
    """Run pytest on the files of a question; hypothesis draws the same every time."""
    import numba
    import pytest

    if question.get("compiled"):  # callers have what they call compiled in: nothing compiled before is good
        numba.config.CACHE_DIR = str(question["compiled"])  # type: ignore[attr-defined]
    options = ["-q", "-m", "not slow and not bench", "--hypothesis-seed=0", "--benchmark-disable", "--tb=no"]
    options += [] if question["all"] else ["-x"]
    options += [f"--deselect={name}" for name in question["without"]]
    status = int(pytest.main([*options, *question["files"]]))
    sys.stdout.flush()
    return status


if __name__ == "__main__":
    sys.exit(main())
