"""Every public function takes recordings, arrays and paths as it says, or refuses: never a bare TypeError."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.errors import DataError, InertialcalError, UsageError

N, RATE = 1_200, 100.0
RNG = np.random.default_rng(1)
VALUES = RNG.normal(0.0, 0.01, (N, 3))
NOUNS = sorted(ic._nouns())
OTHERS = ("budget", "certificate", "check", "compare", "compensate", "info", "load_model", "load_models", "lot", "plot",
          "positions_batch", "programme_1969", "read", "read_certificate", "read_table", "run", "score",
          "write")  # fmt: skip
NEEDED: dict[str, Callable[[Any], tuple[Any, ...]]] = {  # arguments of those that take more than a recording
    "certificate": lambda one: (one, "c.xml"),
    "compare": lambda one: (one, one),
    "compensate": lambda one: ("no_model.json", one),
    "lot": lambda one: (one, "lot_made"),
    "positions_batch": lambda one: (one, 9.8),
    "write": lambda one: ("out.csv", one),
}
NO_CALL = (
    "max_memory",
    "open_archive",
    "plan_allan",
    "plan_flip",
    "plan_magnetometer_bias",
    "plan_mass_attraction",
    "plan_positions",
    "plan_rate_table",
    "plan_thermal",
    "plan_turned_mass",
    "plan_vibration",
    "plan_vibration_survey",
    "simulate",
    "vibration_profile",
)  # that take no recording


def forms() -> dict[str, Any]:
    """Return what people give: in the folder of the test are ``r.csv`` and ``m.bin``."""
    one, other = ic.read("r.csv"), ic.read("r.csv", start=3)
    return {
        "path": "r.csv", "Path": Path("r.csv"), "missing": "no.csv", "bytes": b"r.csv", "[path]": ["r.csv"],
        "recording": one, "[recording]": [one], "(recording,)": (one,), "two": [one, other], "generator": iter([one]),
        "array": VALUES, "axis": VALUES[:, 0], "[array]": [VALUES], "numbers": VALUES.tolist(), "codes": VALUES > 0,
        "mapped": np.memmap("m.bin", dtype=float, mode="r", shape=VALUES.shape),
        "complex": VALUES + 1j, "3-D": np.zeros((2, 3, 4)), "empty array": np.zeros(0), "ragged": [[1.0], [1.0, 2.0]],
        "objects": np.array([one], dtype=object), "words": np.array(["r.csv"]), "fields": np.zeros(5, [("a", float)]),
        "dates": np.array(["2020-01-01"], dtype="M8[s]"), "empty list": [], "None": None, "[None]": [None],
        "number": 3, "mapping": {"x": VALUES},
    }  # fmt: skip


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    rows = (f"{i / RATE:.2f},{x:.6f},{y:.6f},{z:.6f}" for i, (x, y, z) in enumerate(VALUES.tolist()))
    head = "time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]"
    Path("r.csv").write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    VALUES.tofile("m.bin")
    return tmp_path


def _failure(call: Callable[[], object]) -> str:
    """Return what came that is no refusal in words."""
    try:
        call()
    except InertialcalError as error:
        return "" if error.problems[0].what else "a refusal without a word"
    except Exception as error:
        return repr(error)
    return ""


def test_every_public_function_is_tried() -> None:
    assert {*NOUNS, *OTHERS, *NO_CALL} >= {name for name in ic.__all__ if not inspect.isclass(getattr(ic, name))}


@pytest.mark.parametrize("name", [*NOUNS, *OTHERS])
@pytest.mark.usefixtures("folder")
def test_what_cannot_be_taken_is_refused_in_words(name: str) -> None:
    call = getattr(ic, name)
    own = inspect.signature(call).parameters.values()
    rated = any(one.name == "sample_rate" or one.kind == one.VAR_KEYWORD for one in own)
    for form, given in forms().items():
        for said in [{}, {"sample_rate": RATE}] if rated else [{}]:
            failed = _failure(lambda: call(*NEEDED.get(name, lambda one: (one,))(given), **said))  # noqa: B023
            assert not failed, f"{name} of {form} with {said}: {failed}"


@pytest.mark.parametrize("form", ["path", "recording", "[path]", "[recording]", "(recording,)"])
@pytest.mark.usefixtures("folder")
def test_info_and_allan_take_a_recording_in_any_form(form: str) -> None:
    given = forms()[form]
    assert ic.info(given).rows == len(ic.read(given)) == N
    assert ic.allan(given).rows == ic.allan("r.csv").rows


@pytest.mark.parametrize("form", ["array", "[array]", "mapped", "numbers"])
@pytest.mark.usefixtures("folder")
def test_an_array_is_taken_with_its_rate(form: str) -> None:
    given = forms()[form]
    found = ic.info(given, sample_rate=RATE)
    assert [one.mean for one in found.channels] == pytest.approx(VALUES.mean(axis=0))
    with pytest.raises(DataError) as refused:
        ic.info(given)
    assert refused.value.problems[0].code == "no_time"


@pytest.mark.usefixtures("folder")
def test_several_recordings_are_surveyed_one_by_one() -> None:
    with pytest.raises(UsageError) as refused:
        ic.info(forms()["two"])
    assert "2 recordings at once" in str(refused.value)
    assert refused.value.problems[0].code == "wrong_type"


@pytest.mark.parametrize(
    "name",
    ["budget", "certificate", "check", "compare", "load_model", "read_certificate", "read_table", "run", "score"],
)
@pytest.mark.usefixtures("folder")
def test_what_is_named_by_a_path_says_so(name: str) -> None:
    with pytest.raises(UsageError) as refused:
        getattr(ic, name)(*NEEDED.get(name, lambda one: (one,))(forms()["recording"]))
    assert refused.value.problems[0].code == "wrong_type"
    assert "by its path" in str(refused.value)
