"""Start-up: a command loads what it needs, and starts in the processor time that a person does not notice."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from statistics import median

import numpy as np
import pytest

from inertialcal.procedures import BUILT_IN

HEAVY = {"numpy", "scipy", "numba", "pandas", "matplotlib", "pyarrow", "h5py", "yaml", "jinja2"}
# Modules of a procedure that hold no numerics; of positions those that say what an entry of a recording may hold.
LIGHT = {"plan", "procedure", "figures", "entry", "suggest", "given", "gravity", "readings", "planning", "orientations"}
RUNS = 7


@pytest.fixture(scope="module", name="small")
def _small(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A gyro at rest for 200 s, with its units in the header."""
    path = tmp_path_factory.mktemp("small") / "small.csv"
    readings = np.random.default_rng(1).normal(scale=0.1, size=(20_000, 3))
    table = np.column_stack([np.arange(20_000) / 100.0, readings])
    head = "time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]"
    np.savetxt(path, table, fmt=["%.2f", "%.5f", "%.5f", "%.5f"], delimiter=",", header=head, comments="")
    return str(path)


def loaded_by(*words: str) -> set[str]:
    """Return the modules that a command loads."""
    code = (
        "import sys\nfrom inertialcal.cli.__main__ import main\n"
        f"try:\n    main({list(words)!r})\nexcept SystemExit as end:\n    assert not end.code\n"
        "print('LOADED', *sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    return set(done.stdout.rpartition("LOADED")[2].split())


@pytest.mark.parametrize("words", [("--help",), ("--version",), ("allan", "--help"), ("positions", "--help"),
                                   ("thermal", "--help"), ("run", "--help")])  # fmt: skip
def test_help_loads_nothing_heavy(words: tuple[str, ...]) -> None:
    assert not loaded_by(*words) & HEAVY


def test_info_loads_a_reader_and_numpy(small: str) -> None:
    assert loaded_by("info", small) & HEAVY == {"numpy", "pyarrow"}


def test_allan_loads_its_own_numerics(small: str) -> None:
    loaded = loaded_by("allan", small)
    assert not loaded & {"scipy.signal", "scipy.stats", "pandas", "matplotlib", "h5py", "jinja2"}
    parts = [name.split(".") for name in loaded if name.startswith("inertialcal.procedures.")]
    others = set(BUILT_IN) - {"static_noise"}
    assert {".".join(one) for one in parts if one[2] in others and len(one) > 3 and one[3] not in LIGHT} == set()
    assert not {"inertialcal.procedures.positions.planning.planner", "inertialcal.report.page"} & loaded


def processor_time(*words: str) -> float:
    """Return the processor time of a command, median of several after one that warms the caches [s]."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    command = [sys.executable, "-m", "inertialcal.cli", *words]
    times = []
    for _ in range(RUNS + 1):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            command, capture_output=True, check=True, env=environment | {"OMP_NUM_THREADS": "1"}, timeout=120
        )
        now = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(now.ru_utime + now.ru_stime - before.ru_utime - before.ru_stime)
    return median(times[1:])


@pytest.mark.bench
@pytest.mark.parametrize(
    ("words", "limit"),
    [
        (("--help",), 0.2),
        (("allan", "--help"), 0.25),
        (("thermal", "--help"), 0.25),
        (("info", "SMALL"), 0.5),
        (("allan", "SMALL"), 1.2),
    ],
)
def test_processor_time(words: tuple[str, ...], limit: float, small: str) -> None:
    taken = processor_time(*(small if word == "SMALL" else word for word in words))
    print(f"\n{' '.join(words)}: {taken:.2f} s of the processor, limit {limit} s; load {os.getloadavg()[0]:.1f}")
    assert taken < limit
