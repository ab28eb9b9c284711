"""False alarms and power of the screening of one channel, on independent records and faults.

::

    PYTHONPATH=src:tests python -m independent.screened [--n 50]

Seeds are 1 to n. A clean kind counts the records with any finding; a fault, at its size and at smaller ones, counts
those with one of its codes, and those with nothing.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence

import numpy as np

from .faults import FAULTS, Fault, spoiled
from .static import Noise, still

KINDS: dict[str, tuple[Noise, float, float]] = {  # terms, rounding in sigma of the white noise, samples a second
    "white": (Noise(white=4e-3), 0.0, 50.0),
    "flicker": (Noise(white=4e-3, flicker=3e-3), 0.0, 50.0),
    "walk": (Noise(white=4e-3, walk=3e-4), 0.0, 50.0),
    "flicker and walk": (Noise(white=4e-3, flicker=5e-3, walk=1e-4), 0.0, 50.0),
    "flicker alone": (Noise(flicker=3e-3), 0.0, 50.0),
    "walk alone": (Noise(walk=3e-4), 0.0, 50.0),
    "ramp": (Noise(white=4e-3, ramp=5e-5), 0.0, 50.0),
    "rounded 0.3": (Noise(white=4e-3), 0.3, 50.0),
    "rounded 1": (Noise(white=4e-3), 1.0, 50.0),
    "rounded 4": (Noise(white=4e-3), 4.0, 50.0),
    "rounded angle": (Noise(white=2e-3, rounded_angle=1e-4), 0.0, 50.0),
    "low pass 1/10": (Noise(white=4e-3, corner=5.0), 0.0, 50.0),
    "low pass 1/25": (Noise(white=4e-3, corner=2.0, order=2), 0.0, 50.0),
    "line": (Noise(white=4e-3, lines=((0.02, 7.3),)), 0.0, 50.0),
}
SAMPLES = 60_000
SMALLER = {
    "glitch": (8.0, 12.0), "spikes": (10.0,), "bursts": (10.0,), "level_step": (0.35, 0.7), "noise_changed": (1.1, 1.3),
    "thermostat": (0.11, 0.22), "clipping": (1e-4, 1e-3), "stuck": (8.0, 20.0, 60.0), "doubled": (0.2,),
}  # fmt: skip


def codes(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> tuple[str, ...]:
    """Return the codes that the screening finds in one channel."""
    from inertialcal.signals.screening.screen import screen

    return screen(values).codes


def power(fault: Fault, size: float, n: int) -> str:
    """Return the row of one fault at one size."""
    found: Counter[str] = Counter()
    named = nothing = 0
    for seed in range(1, n + 1):
        case = spoiled(still(seed, {"x": Noise(white=4e-3)}, 72_000, 20.0), fault.name, size)
        one = codes(next(iter(case.tables.values())).columns["gyro_x [deg/s]"])
        named += bool(set(one) & set(fault.codes))
        nothing += not one
        found.update(one)
    told = " ".join(f"{code}x{k}" for code, k in found.most_common())
    return f"| {fault.name} | {size:g} {fault.unit} | {n} | {named} | {nothing} | {told} |"


def main(words: Sequence[str] | None = None) -> int:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=50)
    n = parser.parse_args(words).n
    print("| clean | records | with a finding | codes |\n|---|---|---|---|")
    total = 0
    for name, (noise, step, rate) in KINDS.items():
        found: Counter[str] = Counter()
        alarms = 0
        for seed in range(1, n + 1):
            case = still(seed, {"x": noise}, SAMPLES, rate, step=step * noise.white * np.sqrt(rate))
            one = codes(next(iter(case.tables.values())).columns["gyro_x [deg/s]"])
            alarms += bool(one)
            found.update(one)
        total += alarms
        print(f"| {name} | {n} | {alarms} | {' '.join(f'{code}x{k}' for code, k in found.most_common())} |", flush=True)
    print(f"| all | {n * len(KINDS)} | {total} | |\n\n| fault | size | records | its code | nothing | codes |")
    print("|---|---|---|---|---|---|")
    for fault in FAULTS.values():
        if "allan" not in fault.on or fault.name in ("backwards", "backwards_unseen", "lost", "low_pass"):
            continue
        for size in (*SMALLER.get(fault.name, ()), fault.size):
            print(power(fault, size, n), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
