"""The programme of 1969 as plain loops, written from the description of its listing alone; samples count from 1."""

from __future__ import annotations

import math


def means_removed(values: list[float]) -> list[float]:
    mean = sum(values) / len(values)
    return [value - mean for value in values]


def correlation(x: list[float], y: list[float], lag: int) -> float:
    n = len(x)
    return sum(x[i - 1] * y[i + lag - 1] for i in range(1, n - lag + 1)) / (n - lag)


def density(R: list[float], M: int, H: float) -> list[float]:
    """Raw lines K = 0 ... M."""
    found = []
    for K in range(M + 1):
        total = R[0] + (-1) ** K * R[M]
        for L in range(1, M):
            total += 2.0 * R[L] * math.cos(math.pi * L * K / M)
        found.append(2.0 * H * total)
    return found


def smoothed(raw: list[float]) -> list[float]:
    """Lines K = 1 ... M."""
    M = len(raw) - 1
    inside = [0.25 * raw[K - 1] + 0.5 * raw[K] + 0.25 * raw[K + 1] for K in range(1, M)]
    return [*inside, 0.5 * (raw[M - 1] + raw[M])]


def fourier(x: list[float]) -> tuple[list[float], list[float]]:
    N = len(x)
    A, B = [], []
    for K in range(1, 51):
        A.append(2.0 / N * sum(x[i - 1] * math.cos(2 * math.pi * K * (i - 1) / N) for i in range(1, N + 1)))
        B.append(2.0 / N * sum(x[i - 1] * math.sin(2 * math.pi * K * (i - 1) / N) for i in range(1, N + 1)))
    return A, B


def tilt_trace(AX: list[float], AY: list[float]) -> list[float]:
    P = sum(a * b for a, b in zip(AX, AY, strict=True)) / sum(b * b for b in AY)
    return [a - P * b for a, b in zip(AX, AY, strict=True)]


def straight_line(AX: list[float]) -> list[float]:
    first, second = sum(AX[0:9]) / 9.0, sum(AX[91:100]) / 9.0
    return [AX[i - 1] - first - (second - first) * (i - 5) / 91.0 for i in range(1, 101)]


def harmonics(X: list[float], MA: int) -> list[float]:
    A, B = fourier(X)
    left = list(X)
    for K in [*range(1, MA + 1), *range(50 - MA, 51)]:
        for i in range(1, 101):
            angle = 2 * math.pi * K * (i - 1) / 100
            left[i - 1] -= A[K - 1] * math.cos(angle) + B[K - 1] * math.sin(angle)
    return left


def adjusted_curve(AX: list[float], JA: int) -> list[float]:
    def at(i: int) -> float:
        return AX[i - 1]

    curve = {}
    for i in range(JA + 2, 100 - JA):
        curve[i] = (sum(at(j) for j in range(i - JA, i + JA + 1)) + 0.5 * (at(i - JA - 1) + at(i + JA + 1))) / (
            2 * (JA + 1)
        )
    for i in range(3, JA + 2):
        curve[i] = (sum(at(j) for j in range(2, 2 * i - 1)) + 0.5 * (at(1) + at(2 * i - 1))) / (2 * (i - 1))
    curve[1], curve[2] = 0.5 * (at(1) + at(2)), (at(1) + at(2) + at(3)) / 3.0
    for i in range(100 - JA, 99):
        whole = sum(at(j) for j in range(2 * i - 99, 100))
        curve[i] = (whole + 0.5 * (at(2 * i - 100) + at(100))) / (2 * (100 - i))
    curve[99], curve[100] = 0.25 * at(98) + 0.5 * at(99) + 0.25 * at(100), 0.5 * (at(99) + at(100))
    return [at(i) - curve[i] for i in range(1, 101)]
