"""The measurement as the program reduces it: formulas and listing tried on a series whose answer is known.

The mass goes middle, nearest, middle, farthest: sample I = 1, 2, ... is ``NA sin(pi/2 (I - 1))``, N = 100.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .figures import Figure, Section, Variant, figure
from .printed import Printed, Recomputed, exactly, printed, recompute

N, LAGS, LINE, HALF = 100, 50, 25, 3
SAMPLE, PAUSE = 100.0, 20.0  # s
Array = NDArray[np.float64]
Told = dict[str, Printed]
INDEX = np.arange(1, N + 1, dtype=float)


def program_sections(told: Told) -> tuple[Section, ...]:
    """Return frequencies, formulas of Appendix A, and the reductions of the listing."""
    return (_frequencies(told), _formulas(told), _reductions(told))


def _signal(amplitude: float, offset: float = 1.0) -> Array:
    return np.asarray(amplitude * np.sin(0.5 * np.pi * (INDEX - offset)))


def sine_coefficient(series: Array, line: int, offset: float = 1.0) -> float:
    """Return B(K) with the time index I - offset."""
    return float(2.0 / N * np.sum(series * np.sin(2.0 * np.pi * line * (INDEX - offset) / N)))


def psd_amplitude(series: Array, line: int) -> float:
    """Return sqrt(B |G(K)|) from the unbiased correlation with 50 lags."""
    R = np.array([np.sum(series[: N - lag] * series[lag:]) / (N - lag) for lag in range(LAGS + 1)])
    lags = np.arange(1, LAGS)
    inner = R[0] + 2.0 * np.sum(R[1:LAGS] * np.cos(np.pi * lags * line / LAGS)) + (-1.0) ** line * R[LAGS]
    return float(np.sqrt(abs(2.0 * SAMPLE * inner) / (LAGS * SAMPLE)))


def _frequencies(told: Told) -> Section:
    without = Variant("what leaving out the pauses gives: 4 x 100 s", Recomputed(1.0 / (4.0 * SAMPLE)))
    figures = (
        figure(
            "input",
            "input frequency",
            told["input_frequency"],
            Recomputed(1.0 / (4.0 * (SAMPLE + PAUSE))),
            "Hz",
            variants=(without,),
        ),
        figure("bandwidth", "bandwidth of the spectrum", told["bandwidth"], Recomputed(1.0 / (LAGS * SAMPLE)), "Hz"),
        figure("step", "step of frequency", told["frequency_step"], Recomputed(1.0 / (2.0 * LAGS * SAMPLE)), "Hz"),
    )
    how = "Four samples a cycle, each 100 s and 20 s to move the mass; 50 lags of 100 s."
    return Section("frequencies", "Text: frequencies", how, figures)


def _formulas(told: Told) -> Section:
    amplitude, text = told["amplitude"].value, told["amplitude"]
    mended = "what the index I - 1 gives, as the listing has it"
    alternating = np.cos(np.pi * (INDEX - 1.0))
    cosine = float(2.0 / N * np.sum(alternating * np.cos(np.pi * (INDEX - 1.0))))
    figures = (
        figure(
            "A(I)",
            "input NA sin(pi/2 I), B(25)",
            text,
            Recomputed(sine_coefficient(_signal(amplitude, 0.0), LINE)),
            "ng",
            variants=(Variant(mended, Recomputed(sine_coefficient(_signal(amplitude), LINE)), "misprint"),),
        ),
        figure(
            "B(25)",
            "B(25) and Fourier formulas with index I, B(25)",
            text,
            Recomputed(sine_coefficient(_signal(amplitude), LINE, 0.0)),
            "ng",
            variants=(Variant(mended, Recomputed(sine_coefficient(_signal(amplitude), LINE)), "misprint"),),
        ),
        figure("G(25)", "G(25) from the correlation", text, Recomputed(psd_amplitude(_signal(amplitude), LINE)), "ng"),
        figure(
            "harmonic 50",
            "amplitude 1 at K = 50, with the factor 2/N",
            exactly(1),
            Recomputed(cosine),
            variants=(Variant("what the factor 1/N gives", Recomputed(0.5 * cosine), "misprint"),),
        ),
        figure(
            "high harmonics",
            "number of highest harmonics",
            exactly(20),
            Recomputed(float(len(range(LAGS - 20, LAGS + 1)))),
            why="the listing takes 50 - 20 to 50",
        ),
    )
    how = (
        "Each formula, as printed, on a series of known amplitude: 23 ng from the middle position, or 1 at the "
        "highest line; the amplitude must come back."
    )
    return Section("formulas", "Appendix A, formulas", how, figures)


Weights = Callable[[int], dict[int, float]]


def _window(full: range, halves: tuple[int, int], divisor: float) -> dict[int, float]:
    weights = dict.fromkeys(full, 1.0 / divisor)
    for point in halves:
        weights[point] = weights.get(point, 0.0) + 0.5 / divisor
    return weights


def left_window(i: int, listed: bool) -> dict[int, float]:
    """Return the weights at points 3 to JA + 1: as listed, or centred."""
    last = 2 * i - 2
    return _window(range(2, last + 1), (i, last - 1) if listed else (1, last + 1), 2.0 * (i - 1))


def right_window(i: int, listed: bool) -> dict[int, float]:
    """Return the weights at points 100 - JA to 98: as listed, or centred."""
    return _window(range(2 * i - 99, N), (2 * i - N, i if listed else N), 2.0 * (N - i))


def _centre(weights: dict[int, float]) -> float:
    return sum(point * weight for point, weight in weights.items())


def adjusted(series: Array) -> Array:
    """Return a series less its adjusted curve, edges centred where the listing cannot be."""
    special = {
        1: {1: 0.5, 2: 0.5},
        2: dict.fromkeys((1, 2, 3), 1.0 / 3.0),
        N - 1: {98: 0.25, 99: 0.5, 100: 0.25},
        N: {99: 0.5, 100: 0.5},
    }
    result = series.copy()
    for i in range(1, N + 1):
        if i in special:
            weights = special[i]
        elif i <= HALF + 1:
            weights = left_window(i, listed=False)
        elif i >= N - HALF:
            weights = right_window(i, listed=False)
        else:
            weights = _window(range(i - HALF, i + HALF + 1), (i - HALF - 1, i + HALF + 1), 2.0 * (HALF + 1))
        result[i - 1] -= sum(weight * series[point - 1] for point, weight in weights.items())
    return result


def _reductions(told: Told) -> Section:
    amplitude = told["amplitude"]
    left, right = HALF + 1, N - HALF
    trace = _signal(1.0) + 1.0  # a tilt reading with a mean
    data = 2.0 * _signal(1.0)
    with_mean, without = (float(data @ t / (t @ t)) for t in (trace, trace - trace.mean()))
    kept = sine_coefficient(adjusted(_signal(amplitude.value)), LINE)

    def centred(i: int, window: Callable[[int, bool], dict[int, float]]) -> tuple[Printed, Recomputed, Variant]:
        mended = Variant(
            "where the centred window lies, with its half weights on the outermost points",
            Recomputed(_centre(window(i, False))),
            "misprint",
        )
        return exactly(i), Recomputed(_centre(window(i, True))), mended

    two, ninety_nine = 1.0 / 3.0, 0.5
    figures: list[Figure] = [
        figure(
            "reduction 1",
            "reduction 1, a tilt coefficient of 2",
            exactly(2),
            Recomputed(with_mean),
            variants=(Variant("what the series without its mean gives, as in Appendix A", Recomputed(without)),),
        ),
    ]
    for name, i, window in (("left", left, left_window), ("right", right, right_window)):
        shown, found, mended = centred(i, window)
        figures.append(
            figure(
                name,
                f"adjusted curve, {name} edge, centre of the window at point {i}",
                shown,
                found,
                variants=(mended,),
            )
        )
    figures += [
        figure(
            "points 2 and 99",
            "adjusted curve, weight of point 99 in its own mean",
            printed("0.50"),
            recompute(lambda w: w, two),
            why=f"point 2 takes {two:.2f}, point 99 {ninety_nine:.2f}: the edges are not mirror images",
        ),
        figure(
            "input line",
            "adjusted curve, input line left unchanged, B(25)",
            amplitude,
            Recomputed(kept),
            "ng",
            why="true for points 5 to 96; the edges take 1.3 %",
        ),
    ]
    how = "Rules of the listing on known series; a mean that is taken off a point has to be centred on it."
    return Section("reductions", "Appendix B, reductions", how, tuple(figures))
