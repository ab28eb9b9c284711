"""Do stated 95 % intervals hold the truth of the independent simulators? The tables of issues 21 and 22.

::

    PYTHONPATH=src:tests python -m independent.coverage [--n 20] [--case PATTERN ...] [--out FILE.md]

Seeds are 1 to n. A line gives, for a group of figures of one case, how many stated intervals hold the truth, the exact
99.9 % binomial interval of that rate, the error (median, and root mean square), the median of u, and refusals.
"""

from __future__ import annotations

import argparse
import math
import re
import statistics
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.stats import beta

from . import flip, moved_mass, positions, rate_table, static, thermal
from .case import Case
from .trial import Outcome, called, estimates, holds, tried

Truths = Callable[[Case], dict[str, float]]  # truth by the key of an estimate


@dataclass(frozen=True)
class Study:
    """One line or more of a table: a case a seed, and groups of figures."""

    name: str
    stated: str  # what the issue measured
    case: Callable[[int], Case]
    groups: dict[str, Truths]
    notes: Callable[[Case, Outcome], Sequence[str]] = lambda case, outcome: ()


@dataclass
class Count:
    """Hits and errors of one group."""

    hits: int = 0
    n: int = 0
    missing: int = 0
    errors: list[float] = field(default_factory=list)  # estimate less truth
    parts: list[float] = field(default_factory=list)  # the same over the truth
    u: list[float] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)  # of u to that of the best estimate


def binomial(hits: int, n: int, p: float = 0.999) -> tuple[float, float]:
    """Return the exact interval of a rate (Clopper and Pearson 1934)."""
    if not n:
        return 0.0, 1.0
    a = 0.5 * (1.0 - p)
    low = float(beta.ppf(a, hits, n - hits + 1)) if hits else 0.0
    high = float(beta.ppf(1.0 - a, hits + 1, n - hits)) if hits < n else 1.0
    return low, high


def like(pattern: str, of: str = "") -> Truths:
    """Return the truths whose name begins with the pattern; ``of`` is part of the truth's name."""

    def found(case: Case) -> dict[str, float]:
        expression = re.compile(pattern)
        if not of:
            return {key: value for key, value in case.truth.items() if expression.match(key)}
        return {key.replace(f" {of}", ""): value for key, value in case.truth.items() if f" {of}" in key}

    return found


def counted(study: Study, n: int) -> tuple[dict[str, Count], Counter[str], Counter[int]]:
    """Run a study, seeds 1 to n."""
    counts = {name: Count() for name in study.groups}
    notes: Counter[str] = Counter()
    exits: Counter[int] = Counter()
    for seed in range(1, n + 1):
        case = study.case(seed)
        outcome = tried(case)
        exits[outcome.exit] += 1
        notes.update(study.notes(case, outcome))
        rows = estimates(outcome, "rates" if case.procedure == "rate_table" else "")
        for name, truths in study.groups.items():
            add(counts[name], rows, truths(case), case.ideal)
    return counts, notes, exits


def add(count: Count, rows: dict[str, dict[str, object]], truths: dict[str, float], ideal: dict[str, float]) -> None:
    """Count the estimates of one campaign."""
    for key, truth in truths.items():
        row = rows.get(key)
        held = holds(row, truth) if row else None
        if row is None or held is None:
            count.missing += 1
            continue
        error = float(row["value"]) - truth  # type: ignore[arg-type]
        count.hits += held
        count.n += 1
        count.errors.append(error)
        count.parts.append(error / truth if truth else math.nan)
        count.u.append(float(row["u"]))  # type: ignore[arg-type]
        if key in ideal:
            count.ratios.append(count.u[-1] / ideal[key])


def lines(study: Study, n: int) -> list[str]:
    """Return the rows of one study."""
    counts, notes, exits = counted(study, n)
    told = " ".join(f"{code}x{number}" for code, number in notes.most_common(6))
    out = " ".join(f"{code}x{number}" for code, number in sorted(exits.items()))
    rows = []
    for name, one in counts.items():
        low, high = binomial(one.hits, one.n)
        rate = f"{100 * one.hits / one.n:.0f}" if one.n else "-"
        rms = math.sqrt(statistics.fmean(e * e for e in one.errors)) if one.errors else math.nan
        part = statistics.median(one.parts) if one.parts else math.nan
        u = statistics.median(one.u) if one.u else math.nan
        cells = [study.name, name, study.stated, f"{one.hits}/{one.n}", rate, f"{100 * low:.0f}-{100 * high:.0f}"]
        ratio = f"{statistics.median(one.ratios):.3g}" if one.ratios else ""
        cells += [f"{100 * part:.2g} %", f"{rms:.2g}", f"{u:.2g}", ratio, str(one.missing), out, told]
        rows.append("| " + " | ".join(cells) + " |")
    return rows


HEAD = (
    "| case | figure | issue | held | % | 99.9 % interval | median error | rms error | median u | u / ideal | absent | "
    "exits | notes |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)


# Issue 21


def remarks(*codes: str) -> Callable[[Case, Outcome], Sequence[str]]:
    """Count remarks and errors of these codes, once a campaign."""
    return lambda case, outcome: sorted({code for code, _ in outcome.said} & set(codes))


def tables() -> list[Study]:
    """Rate table: turn-on bias against the asymmetry."""
    groups = {
        "asymmetry": like("scale_factor_asymmetry"),
        "scale factor": like("scale_factor_error"),
        "misalignment": like("misalignment"),
        "bias": like("bias"),
    }
    found = []
    for runs, turn_on, stated in (
        (1, 0.0, "94"),
        (1, 0.003, "81"),
        (1, 0.01, "56"),
        (1, 0.03, "42"),
        (5, 0.0, ""),
        (5, 0.01, "rms 0.28 % (own intercepts 0.10)"),
        (5, 0.05, "rms 1.37 % (own intercepts 0.10)"),
    ):
        gyros = rate_table.Gyros(turn_on=turn_on, dwell=0.003)
        protocol = rate_table.Protocol(runs=runs)
        found.append(
            Study(
                f"rate_table, {runs} run(s) an axis, turn-on {turn_on} deg/s",
                stated,
                partial(rate_table.reduced, gyros=gyros, protocol=protocol),
                groups,
            )
        )
    fast = rate_table.Protocol(rates=(-100.0, -50.0, -20.0, 20.0, 50.0, 100.0))
    cubic = rate_table.Gyros(turn_on=0.003, dwell=0.003, asymmetry=(1e-3, 0.0, 2e-3), k2=(2e-5,) * 3, k3=(2e-6,) * 3)
    found.append(
        Study(
            "rate_table, K2 = 2e-5, K3 = 2e-6",
            "to be built",
            partial(rate_table.reduced, gyros=cubic, protocol=fast),
            groups,
        )
    )
    return found


def intercepts(n: int) -> list[str]:
    """Asymmetry by a fit with an intercept a run, for comparison: root mean square of its errors [%]."""
    rows = []
    for turn_on in (0.0, 0.01, 0.05):
        errors = []
        for seed in range(1, n + 1):
            case = rate_table.reduced(seed, rate_table.Gyros(turn_on=turn_on, dwell=0.003))
            found = rate_table.asymmetries(case)
            errors += [found[axis] - case.truth[f"scale_factor_asymmetry {axis}"] for axis in "xyz"]
        rms = math.sqrt(statistics.fmean(e * e for e in errors))
        rows.append(f"intercept a run, 5 runs, turn-on {turn_on} deg/s: asymmetry rms {rms:.2g} %")
    return rows


def hands() -> list[Study]:
    """Positions: face errors that repeat, flicker of gyros, ill-determined positions."""
    faces = {
        "misalignment": like("misalignment"),
        "bias": like("bias"),
        "scale factor": like("scale_factor_error"),
    }
    found = [
        Study(
            f"positions, six faces laid {times}x, face error 0.5 deg",
            stated,
            partial(positions.six_faces, repeats=times),
            faces,
        )
        for times, stated in ((2, "misalignment 79, bias 85, scale 79"), (1, "scale factor u 20 times too large"))
    ]
    for b, stated in ((0.0, ""), (2e-5, "79"), (1e-4, "63"), (5e-4, "44")):
        unit = positions.Unit(upper_triangular=True, gyro_flicker=b)
        found.append(
            Study(
                f"positions by hand, gyro flicker {b:g} rad/s",
                stated,
                partial(positions.by_hand, unit=unit),
                {
                    "gyro bias b0": like(r"bias [xyz] gyro"),
                    "gyro bias of these rests": like("", "of these rests"),
                    "gyro bias of the next record": like("", "of the next record"),
                    "acc bias": like(r"bias [xyz] accelerometer"),
                    "gyro scale factor": like(r"scale_factor_error [xyz] gyro"),
                },
            )
        )
    found.append(
        Study(
            "positions by hand, 10 positions, condition 50 to 1300",
            "all parameters off",
            partial(positions.by_hand, positions=10, condition=(50.0, 1300.0), cone=100.0),
            {"acc": like(r".* accelerometer"), "gyro scale factor": like(r"scale_factor_error [xyz] gyro")},
            remarks("not_observable", "no_dof"),
        )
    )
    return found


def left_out(n: int) -> list[str]:
    """Leave one position out of ill-determined ones: error of gravity there, by the command, by no fit, by a prior."""
    names = ("command", "raw readings", "numpy, prior 0.02")
    seeds: dict[str, list[float]] = {name: [] for name in names}
    for seed in range(1, n + 1):
        case = positions.tumbled(seed)
        table = case.tables["rests.csv"]
        y = np.column_stack([table.columns[name] for name in table.signals])
        mine: dict[str, list[float]] = {name: [] for name in names}
        for k in range(len(y)):
            rest = case.copy()
            rest.tables["rests.csv"].taken(np.delete(np.arange(len(y)), k))
            rows = estimates(tried(rest))
            A, b = np.eye(3), np.zeros(3)
            for i, axis in enumerate("xyz"):
                b[i] = value(rows, f"bias {axis} accelerometer", 0.0)
                A[i, i] = 1.0 + 0.01 * value(rows, f"scale_factor_error {axis} accelerometer", 0.0)
            for i, j in ((1, 0), (2, 0), (2, 1)):
                A[i, j] = A[i, i] * value(rows, f"misalignment {'xyz'[i]}{'xyz'[j]} accelerometer", 0.0)
            prior = positions.with_prior(np.delete(y, k, axis=0), case.noise)
            for name, (M, c) in {
                "command": (A, b), "raw readings": (np.eye(3), np.zeros(3)), "numpy, prior 0.02": prior,
            }.items():  # fmt: skip
                mine[name].append(float(np.linalg.norm(np.linalg.solve(M, y[k] - c)) - positions.G))
        for name, found in mine.items():
            seeds[name].append(math.sqrt(statistics.fmean(e * e for e in found)))
    return [
        f"leave one out, 10 positions, condition 50 to 1300, {name}: rms of a recording, median "
        f"{statistics.median(one):.3g}, worst {max(one):.3g} m/s^2 ({n} recordings)"
        for name, one in seeds.items()
    ]


def value(rows: dict[str, dict[str, object]], key: str, default: float) -> float:
    """Return an estimate, or the default where there is none."""
    row = rows.get(key)
    return float(row["value"]) if row and row["status"] == "estimated" else default  # type: ignore[arg-type]


def chambers() -> list[Study]:
    """Thermal: two and five power-ups."""
    unit = thermal.Unit(hysteresis=0.002, lag=30.0, slope_scatter=2e-6, walk=5e-6, turn_on=0.003)
    groups = {
        "bias": like(r"bias x"),
        "slope": like(r"bias_temperature_1"),
        "hysteresis": like("hysteresis"),
        "lag": like("thermal_lag"),
    }
    quiet = thermal.Unit(turn_on=0.003, walk=5e-6)
    unknown = thermal.Unit(turn_on=0.01, attitude=False, hysteresis=0.002, slope_scatter=2e-6)
    found = []
    for runs, stated in ((2, "bias 86-88, lag 81, hysteresis 88"), (5, "bias 95, slope 88, hysteresis 89")):
        chamber = thermal.Chamber(runs=runs)
        found.append(
            Study(
                f"thermal, {runs} power-ups",
                stated,
                partial(thermal.ramped, unit=unit, chamber=chamber),
                groups,
            )
        )
        found.append(
            Study(
                f"thermal, {runs} power-ups, attitude unknown",
                stated,
                partial(thermal.ramped, unit=unknown, chamber=chamber),
                groups | {"path difference": like("path_difference")},
            )
        )
        found.append(
            Study(
                f"thermal, {runs} power-ups, no warm-up simulated",
                "found in 6 % (five), 20 % (two)",
                partial(thermal.ramped, unit=quiet, chamber=chamber),
                {"bias": like(r"bias x")},
                lambda case, outcome: [
                    "warm_up_change found"
                    for row in outcome.rows
                    if row["quantity"] == "warm_up_change" and row["status"] == "estimated"
                ],
            )
        )
    return found


def differences(n: int) -> list[str]:
    """Compare two tests of one unit on one table: difference over stated u, and a change of 6 times its scatter."""
    rows = []
    standards = {"rate_table.rate": "0.05 %", "rate_table.mounting": "2 mrad"}
    protocol = rate_table.Protocol(standards=standards)
    gyros = rate_table.Gyros(turn_on=0.003, dwell=0.003, table_rate=5e-4, fixture=2e-3)
    scatter = math.sqrt(2.0) * 9e-5  # of the scale factor, by the dwells alone: seen in the table above
    for name, remounted, change in (
        ("same mounting", False, 0.0), ("remounted", True, 0.0), ("scale factors changed by 6 scatters", False, 6.0),
    ):  # fmt: skip
        x, y, w = (one + change * scatter for one in gyros.scale)
        other = replace(gyros, scale=(x, y, w))
        z: dict[str, list[float]] = {}
        shown: Counter[str] = Counter()
        itself: list[float] = []
        for seed in range(1, n + 1):
            with tempfile.TemporaryDirectory(prefix="independent_") as text:
                folders = [str(Path(text) / one) for one in ("a", "b")]
                for again, (folder, unit) in enumerate(zip(folders, (gyros, other), strict=True)):
                    case = rate_table.reduced(seed, unit, protocol, again, remounted and again > 0)
                    called(case.write(Path(folder)), Path(folder))
                found = called(["compare", *folders], Path(text))
                same = called(["compare", folders[0], folders[0]], Path(text)) if not (change or remounted) else None
            for row in found.rows:
                if row["status"] == "estimated" and row["u"] and row["test"] in ("", None, "model"):
                    z.setdefault(row["quantity"], []).append(row["value"] / row["u"])
                    shown[f"{row['quantity']} {row['verdict']}"] += 1
            itself += [row["u"] for row in same.rows if row["quantity"] == "scale_factor_error"] if same else []
        for quantity in ("scale_factor_error", "misalignment", "bias"):
            values = z.get(quantity, [])
            rms = math.sqrt(statistics.fmean(v * v for v in values)) if values else math.nan
            told = f"{shown[f'{quantity} different']} of {len(values)} shown different"
            rows.append(f"compare, one table, {name}: {quantity} rms z {rms:.2f}, {told}")
        if itself:
            rows.append(f"compare A A: u of the scale factor {statistics.median(itself):.2g} %")
    return rows


# Issue 22


def masses() -> list[Study]:
    """Moved mass: drifts that repeat, tilt, gain, jumps."""
    found = []
    for shape, size, stated in (
        ("none", 0.0, "-1 %, 1.00"),
        ("line", 1e4, "-1 %, 1.00"),
        ("exp10", 30.0, "-2.6 %, 0.83"),
        ("exp10", 300.0, "-15.9 %, 0.00"),
        ("exp3", 1000.0, "-15 %, 0.00"),
        ("exp30", 1000.0, "-143 % (prototype)"),
        ("cubic", 1000.0, "-13 %, 0.00"),
        ("sine3", 300.0, "thermostat +23 %"),
        ("kink", 1000.0, "-11 % (prototype)"),
        ("sqrt", 1000.0, "-2.3 % (prototype)"),
        ("sine6.7", 1000.0, "+8 % (prototype)"),
        ("sine5", 100.0, "-23 % (prototype)"),
        ("sawtooth", 10.0, "+10 % (prototype)"),
        ("smooth", 100.0, "right, 0.93-0.95"),
        ("walk", 100.0, "slip refused 9 of 30"),
    ):
        bench = moved_mass.Bench(shape=shape, size=size)
        found.append(
            Study(
                f"mass, {shape} {size:g}x",
                stated,
                partial(moved_mass.moved, bench=bench),
                {"scale factor": like("scale_factor x")},
                remarks(
                    "schedule_slip",
                    "runs_agree_too_well",
                    "runs_differ",
                    "below_floor",
                    "far_from_nominal",
                    "wrong_sign",
                ),
            )
        )
    for shape, size in (("sine5", 100.0), ("sawtooth", 10.0)):
        bench = moved_mass.Bench(shape=shape, size=size)
        found.append(
            Study(
                f"mass, {shape} {size:g}x, alternating phase",
                "-.01 %, .955 (prototype)",
                partial(moved_mass.moved, bench=bench, schedule=moved_mass.Schedule(alternating=True)),
                {"scale factor": like("scale_factor x")},
                remarks("schedule_slip", "runs_differ", "below_floor"),
            )
        )
    tilted = moved_mass.Bench(tilt=4e-9, meter=2e-9)
    for use, stated in (("regressed", "+17.5 %, u 7 %, 0.17"), ("known", "")):
        found.append(
            Study(
                f"mass, tilt 4e-9 rad, {use}",
                stated,
                partial(moved_mass.moved, bench=tilted, tilt=use),
                {"scale factor": like("scale_factor x")},
                remarks("tilt_in_phase"),
            )
        )
    for name, stated in (("gain_mid", ""), ("gain_mid_all", "+19.6 %"), ("jump", "+5 %, 0.5"), ("slip", "refused")):
        found.append(
            Study(
                f"mass, {name}",
                stated,
                partial(spoilt, fault=name),
                {"scale factor": like("scale_factor x")},
                remarks("schedule_slip", "runs_differ"),
            )
        )
    return found


def spoilt(seed: int, fault: str) -> Case:
    """Return runs of a moved mass with a fault."""
    from .faults import spoiled

    return spoiled(moved_mass.moved(seed), fault)


def heads() -> list[Study]:
    """Flips: windows given, ambient change, turns to be found."""
    groups = {
        "bias": like(r"bias [yz]"),
        "bias over the record": like("", "over the record"),
        "ambient acceleration": like("ambient_acceleration"),
    }
    control = remarks("control_axis_not_zero", "flips_differ", "not_turned_by_angle", "short_record", "no_noise")
    changing = flip.Head(ambient_rate=(3.0, 3.0, 3.0))
    long = flip.Programme(dwells=2, dwell=(3900.0, 4100.0), before=600.0)
    found = [
        Study("flip, six dwells given, white 20 ug", "u 0.001 for 0.07; 3 of 18", flip.turned, groups, control),
        Study(
            "flip, ambient changes 3 ug/h, a turn between two dwells of 67 min",
            "off 1.5 ug, 0 of 20",
            partial(flip.turned, head=changing, programme=long),
            groups,
            control,
        ),
        Study(
            "flip, slow noise 0.3 ug",
            "",
            partial(flip.turned, head=flip.Head(slow=0.3)),
            groups,
            control,
        ),
    ]

    def turns(case: Case, outcome: Outcome) -> Sequence[str]:
        said = next((text for code, text in outcome.said if code == "turns_found"), "0 turns")
        number = re.search(r"(\d+) turns?", said)
        return [f"{number.group(1) if number else 0} turns"]

    finding = flip.Programme(given=False)
    clear = flip.Head(ambient=(1.0, 3.0, -3.0))
    faint = replace(clear, lever=0.05, shake=2.0)
    found += [
        Study(
            "flip, turns to find, step 6 ug",
            "all five in 2 of 9",
            partial(flip.turned, head=clear, programme=finding),
            groups,
            turns,
        ),
        Study(
            "flip, the same, felt less",
            "all five in 2 of 9",
            partial(flip.turned, head=faint, programme=finding),
            groups,
            turns,
        ),
    ]
    return found


def noises() -> list[Study]:
    """Allan: low passes, walks and flicker."""
    found = []
    for corner in (5.0, 10.0, 20.0, 44.0):
        noise = static.Noise(white=0.004, corner=corner)
        for order in (1, 2):
            one = replace(noise, order=order)
            found.append(
                Study(
                    f"allan, low pass {corner:g} Hz order {order}, 50 Hz",
                    {5.0: "kalibr 0.24", 10.0: "kalibr 0.26", 20.0: "kalibr 0.56", 44.0: "kalibr 1.1"}[corner],
                    partial(exported, noises={"x": one}, n=180_000, rate=50.0),
                    {"angle random walk": like("angle_random_walk")},
                    densities,
                )
            )

    def terms(case: Case, outcome: Outcome) -> Sequence[str]:
        wanted = ("bias_instability", "rate_random_walk", "rate_ramp", "gauss_markov_sigma")
        return [row["quantity"] for row in outcome.rows if row["quantity"] in wanted and row["status"] == "estimated"]

    walk = {"x": static.Noise(white=0.004, walk=4e-5)}
    both = {"x": static.Noise(white=0.004, walk=2e-5, flicker=1e-3)}
    for name, noise_of, stated in (
        ("white and walk", walk, "read as flicker 44 of 250"),
        ("white, flicker, walk", both, "flicker 0.85-0.88"),
        ("white", {"x": static.Noise(white=0.004)}, ""),
    ):
        found.append(
            Study(
                f"allan, {name}",
                stated,
                partial(static.still, noises=noise_of, n=72_000, rate=20.0),
                {
                    "angle random walk": like("angle_random_walk"),
                    "rate random walk": like("rate_random_walk"),
                    "bias instability": like("bias_instability"),
                },
                terms,
            )
        )
    found += [
        Study("sine, drive 4 s, samples 1 s", "", moved_mass.driven, {"amplitude": like("amplitude")}),
        Study(
            "sine, the hint obeyed (--averaging 10 s)",
            "180.4 +- 0.3, truth 23",
            partial(moved_mass.driven, words=("--averaging", "10 s")),
            {"amplitude": like("amplitude")},
        ),
    ]
    return found


def exported(seed: int, noises: dict[str, static.Noise], n: int, rate: float) -> Case:
    """Return a record at rest, with the settings of a filter asked for."""
    case = static.still(seed, noises, n, rate)
    case.words += ["--for", "kalibr"]
    return case


def densities(case: Case, outcome: Outcome) -> Sequence[str]:
    """Return the density of the export over the truth, in tenths."""
    found = re.search(r"gyroscope_noise_density: ([0-9.e+-]+)", outcome.printed)
    truth = float(np.radians(case.truth["angle_random_walk x"])) / 60.0
    walk = re.search(r"gyroscope_random_walk: ([0-9.e+-]+)", outcome.printed)
    return [f"density {float(found.group(1)) / truth:.1f}" if found else "density none", *(["walk"] if walk else [])]


def main(words: Sequence[str] | None = None) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=20)
    parser.add_argument("--case", nargs="*", default=[])
    parser.add_argument("--out", type=Path)
    given = parser.parse_args(words)
    text = [HEAD]
    for study in (*tables(), *hands(), *chambers(), *masses(), *heads(), *noises()):
        if not given.case or any(one in study.name for one in given.case):
            text += lines(study, given.n)
            print("\n".join(lines_of(text, study)), file=sys.stderr, flush=True)
    if not given.case or "differences" in given.case:
        text += ["", *intercepts(max(100, given.n)), *differences(given.n)]
    if not given.case or "left out" in given.case:
        text += ["", *left_out(min(10, given.n))]
    print("\n".join(text))
    if given.out:
        given.out.write_text("\n".join(text) + "\n", encoding="utf-8")
    return 0


def lines_of(text: Sequence[str], study: Study) -> list[str]:
    """Return the lines of one study."""
    return [line for line in text if line.startswith(f"| {study.name} |")]


if __name__ == "__main__":
    sys.exit(main())
