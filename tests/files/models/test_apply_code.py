"""The code that applies a model, run: the Python by exec, the C by the compiler, both against compensate."""

from __future__ import annotations

import ctypes
import io
import re
import subprocess
import sys
import tokenize
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from inertialcal.core.estimate import Array
from inertialcal.files.models.apply_c import c_text
from inertialcal.files.models.apply_python import python_text
from inertialcal.files.models.model_file import load_model_file
from inertialcal.sensors.catalogue import flight_unit
from inertialcal.sensors.model.compensate import compensate
from inertialcal.sensors.model.equation import Conditions, by_name, needed, predict
from inertialcal.sensors.model.sensor_model import Item, SensorModel, to_output

sys.path.insert(0, str(Path(__file__).parents[2] / "sensors"))
from random_models import conditions, inputs, random_model

AGREE = 1e-12  # of full scale
STRICT = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic"]
ORDER = ("temperature", "pressure", "time", "temperature_rate", "specific_force")  # of the arguments
HOSTILE = (
    'a\nimport os; os.abort()\n#include "/etc/passwd"',
    "*/ int main(void) { return 1; } /*",
    '""" + __import__("os").abort() + """',
    "it's \\",
    "trigraph ??/",
    "??/\n",
    "*??/\n/",
    "/*/ //*",
    "coding: utf-7",
    "é\u202e\u2028\x00\x07\r\x0c\ud800",
    "%s {0} {i} ${x}",
    "*" * 4000,
    "w " * 4000,
)


def models() -> list[tuple[str, SensorModel]]:
    """Random ones over all terms and 1 to 4 sensors, each curve form, and the published ones."""
    drawn = [(f"seed {seed}", random_model(seed)) for seed in range(40)]
    drawn += [(f"linear {seed}", random_model(seed, linear=True, k=3)) for seed in range(5)]
    whole = random_model(7, k=3)
    span = float(whole.input_range.max()) if whole.input_range is not None else 1.0
    drawn += [
        ("asymmetry alone", replace(whole, scale_factor_asymmetry=np.array([0.1, -0.05, 0.0]),
                                    second_order=None, third_order=None)),
        ("one third order", replace(whole, scale_factor_asymmetry=None, second_order=None,
                                    third_order=np.array([0.0, -0.02, 0.02]) / span**2)),
        ("no range", replace(random_model(3, linear=True), input_range=None, temperature_range=None)),
    ]  # fmt: skip
    return drawn + [(f"flight {name}", model) for name, model in flight_unit().models.items()]


MODELS = dict(models())
each_model = pytest.mark.parametrize(
    "model",
    [*(pytest.param(one, marks=pytest.mark.slow if i % 3 else []) for i, one in enumerate(MODELS)), "published"],
    indirect=True,
)


@pytest.fixture(scope="session")
def published_model(published_report: Path) -> SensorModel:
    return load_model_file(published_report.with_name("model.json")).model


@pytest.fixture
def model(request: pytest.FixtureRequest) -> SensorModel:
    found = MODELS.get(request.param)
    return request.getfixturevalue("published_model") if found is None else found


def loaded(text: str) -> Callable[..., Any]:
    space: dict[str, Any] = {}
    exec(compile(text.encode(), "applied.py", "exec"), space)
    found = space["compensate"]
    assert callable(found)
    return found  # type: ignore[no-any-return]


def built(text: str, cc: str, folder: Path) -> ctypes.CDLL:
    (folder / "applied.c").write_bytes(text.encode("ascii"))
    library = folder / "applied.so"
    command = [cc, *STRICT, "-shared", "-fPIC", str(folder / "applied.c"), "-o", str(library), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(library))


def readings(model: SensorModel, seed: int) -> tuple[Array, Conditions]:
    """Inputs over the range, beyond it on two rows, zero and missing ones; temperatures beyond theirs on one."""
    here = conditions(model, seed)
    np.asarray(here["temperature"])[5] = 80.0
    np.asarray(here["channels"]["supply"])[7] = 5.2
    x = inputs(replace(model, input_range=full(model)), seed)
    x[3:5] *= 1.5
    output = to_output(model, predict(model, x, **here))
    output[6, 0] = np.nan
    return output, here


def full(model: SensorModel) -> Array:
    if model.input_range is None:
        return np.array([[-1.0, 1.0]] * len(model.axes))
    return model.input_range


def row(model: SensorModel, here: Conditions, n: int) -> dict[str, Any]:
    """Conditions of one reading, in the order of the arguments; temperatures one a sensor."""
    columns: Mapping[str, Any] = here
    given: dict[str, Any] = {name: np.asarray(columns[name])[n] for name in ORDER if name in needed(model)}
    channels = [one.channel for one in model.sensitivities if one.channel not in ORDER]
    given |= {f"channel_{name}": np.asarray(here["channels"][name])[n] for name in channels}
    for name in {"temperature", "temperature_rate"} & set(given):
        given[name] = np.array(np.broadcast_to(given[name], len(model.axes)))
    return given


def by_python(model: SensorModel, output: Array, here: Conditions, text: str = "") -> tuple[Array, Array]:
    function = loaded(text or python_text(model))
    pairs = [function(v, **row(model, here, n)) for n, v in enumerate(output)]
    return np.array([x for x, _ in pairs]), np.array([holds for _, holds in pairs])


def by_c(model: SensorModel, output: Array, here: Conditions, library: ctypes.CDLL) -> tuple[Array, Array]:
    double = ctypes.POINTER(ctypes.c_double)
    k = len(model.axes)
    xs, held = np.full(output.shape, 99.0), np.full(output.shape, 9, dtype=np.int32)
    for n, v in enumerate(output):
        given = [np.require(value, requirements="C") for value in row(model, here, n).values()]
        passed = [ctypes.c_double(float(a)) if a.ndim == 0 else a.ctypes.data_as(double) for a in given]
        x, holds = np.empty(k), np.empty(k, dtype=np.int32)
        whole = library.compensate(
            np.ascontiguousarray(v).ctypes.data_as(double),
            *passed,
            x.ctypes.data_as(double),
            holds.ctypes.data_as(ctypes.POINTER(ctypes.c_int)),
        )
        assert whole == int(holds.all())
        xs[n], held[n] = x, holds
    return xs, held.astype(bool)


def worst(model: SensorModel, output: Array, here: Conditions, x: Array) -> float:
    """Largest difference from sensors.model.compensate, of full scale; infinite where one has NaN the other gives."""
    expected = compensate(model, output / model.scale_factor, **here)
    whole = ~np.isnan(output).any(axis=1)
    if np.any(np.isnan(expected) & ~np.isnan(x)) or not np.isnan(x[6, 0]):
        return np.inf
    alike = whole & ~np.isnan(expected).any(axis=1)
    if np.isnan(x[alike]).any() or alike.sum() < 40:
        return np.inf
    return float(np.max(np.abs(x - expected)[alike])) / float(np.max(np.abs(full(model))))


def holds_there(model: SensorModel, x: Array, here: Conditions) -> NDArray[np.bool_]:
    """Where the model says that it holds, by its words: input, temperature and pressure inside their ranges."""
    inside: NDArray[np.bool_] = np.isfinite(x)
    columns: Mapping[str, Any] = here
    if model.input_range is not None:
        inside &= (x >= model.input_range[:, 0]) & (x <= model.input_range[:, 1])
    for name in ("temperature", "pressure"):
        ends = getattr(model, f"{name}_range")
        if ends is not None and name in needed(model):
            values = np.asarray(columns[name]).reshape(len(x), -1)
            inside &= np.all((values >= ends[0]) & (values <= ends[1]), axis=1)[:, np.newaxis]
    for one in model.sensitivities:
        if one.range is not None:
            values = np.asarray(by_name(here)[one.channel])
            inside &= ((values >= one.range[0]) & (values <= one.range[1]))[:, np.newaxis]
    return inside


@each_model
def test_python_gives_what_compensate_gives(model: SensorModel) -> None:
    output, here = readings(model, 1)
    x, holds = by_python(model, output, here)
    assert worst(model, output, here, x) <= AGREE
    np.testing.assert_array_equal(holds, holds_there(model, x, here))


@each_model
def test_c_gives_what_compensate_gives(model: SensorModel, need: Callable[[str], str], tmp_path: Path) -> None:
    library = built(c_text(model), need("cc"), tmp_path)
    output, here = readings(model, 2)
    x, holds = by_c(model, output, here, library)
    assert worst(model, output, here, x) <= AGREE
    np.testing.assert_array_equal(holds, holds_there(model, x, here))


def test_the_ranges_are_met_on_both_sides() -> None:
    """The comparison of `holds` is worth something: readings stand inside and outside."""
    output, here = readings(MODELS["seed 3"], 1)
    _, holds = by_python(MODELS["seed 3"], output, here)
    assert holds.any()
    assert not holds.all()


def test_a_transposed_matrix_is_seen(need: Callable[[str], str], tmp_path: Path) -> None:
    model = random_model(5, k=3)
    turned = replace(model, matrix=model.matrix.transpose(0, 2, 1))
    output, here = readings(model, 1)
    assert worst(model, output, here, by_python(model, output, here, python_text(turned))[0]) > 1e-4
    library = built(c_text(turned), need("cc"), tmp_path)
    assert worst(model, output, here, by_c(model, output, here, library)[0]) > 1e-4


def test_every_digit_of_every_coefficient_stands_there() -> None:
    model = MODELS["seed 0"]
    for text in (python_text(model), c_text(model)):
        for name, values in model.terms.items():
            if name == "bias_run_to_run" or (name == "reference_temperature" and "T_ref" not in text):
                continue
            assert all(repr(float(value)) in text for value in values.ravel()), name


@pytest.mark.parametrize("seed", range(5))
def test_a_matrix_that_nothing_changes_is_inverted_beforehand(seed: int) -> None:
    """Each entry is the closest double of an entry of the inverse: M times it misses I by half a last digit at most."""
    model = replace(random_model(seed, k=3), sensitivities=())
    model = replace(model, matrix=model.matrix[:1])
    text = c_text(model)
    assert "solve(" not in text
    rows = re.search(r"M_INVERSE\[3\]\[3\] = \{.*?\n(.*?)\n\};", text, re.S)
    assert rows is not None
    inverse = [[Fraction(float(entry)) for entry in row.strip(" {},").split(",")] for row in rows[1].splitlines()]
    M = [[Fraction(float(entry)) for entry in row] for row in model.matrix[0]]
    for i in range(3):
        for j in range(3):
            halves = [Fraction(float(np.spacing(abs(float(inverse[m][j]))))) / 2 for m in range(3)]
            off = sum((M[i][m] * inverse[m][j] for m in range(3)), Fraction(-int(i == j)))
            assert abs(off) <= sum((abs(M[i][m]) * halves[m] for m in range(3)), Fraction(0))


def test_a_matrix_over_temperature_is_inverted_where_it_is_used() -> None:
    model = next(one for one in MODELS.values() if one.matrix.shape[0] > 1)
    assert "solve(m, u, x)" in c_text(model)
    assert "M_INVERSE" not in c_text(model)


@pytest.mark.parametrize("text", [python_text, c_text])
def test_what_code_cannot_do_is_said(text: Callable[[SensorModel], str]) -> None:
    model = replace(MODELS["seed 3"], bias_run_to_run=np.full(len(MODELS["seed 3"].axes), 0.125))
    said = text(model)
    assert "no code can remove it" in said
    assert "0.125" in said
    assert "inertialcal compensate MODEL DATA -o OUT --uncertainty" in said
    assert "Hold-out recordings have not confirmed" in said
    assert "row = the sensor that reads, column = the axis that moves" in said


def test_a_range_that_no_argument_meets_is_said(published_model: SensorModel) -> None:
    model = replace(published_model, temperature_range=(-10.0, 50.0))
    assert "temperature of -10.0 to 50.0 degC" in " ".join(python_text(model).replace("#", " ").split())


def turning() -> SensorModel:
    """A curve that turns inside the validity range: no inverse."""
    span = np.array([[-1.0, 1.0]] * 2)
    return SensorModel("gyro", ("x", '*/"\n'), np.ones(2), "V", np.eye(2), np.zeros(2), input_range=span,
                       second_order=np.array([0.0, 0.9]))  # fmt: skip


def test_a_model_without_inverse_gives_the_reason_and_no_function(need: Callable[[str], str], tmp_path: Path) -> None:
    python, c = python_text(turning()), c_text(turning())
    for text in (python, c):
        assert "No function" in text
        assert "two inputs give one reading" in text
    space: dict[str, Any] = {}
    exec(python, space)
    assert "compensate" not in space
    with_something = c + "int nothing(void);\n"  # an empty file is no C99
    built(with_something, need("cc"), tmp_path)


def named(text: str, model: SensorModel) -> SensorModel:
    axes = tuple(f"{text.replace('_', '-')}{i}" for i in range(len(model.axes)))
    return replace(model, axes=axes, item=Item(text, text, text), source=text, estimate=None)


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_no_name_breaks_out(text: str, need: Callable[[str], str], tmp_path: Path) -> None:
    plain = replace(MODELS["seed 3"], bias_run_to_run=None)
    model = named(text, plain)
    python, c = python_text(model), c_text(model)
    assert python.isascii()
    assert c.isascii()
    output, here = readings(model, 1)
    np.testing.assert_array_equal(by_python(model, output, here)[0], by_python(plain, output, here)[0])
    assert worst(model, output, here, by_c(model, output, here, built(c, need("cc"), tmp_path))[0]) <= AGREE
    assert preprocessed(c, need("cc")) == preprocessed(c_text(plain), need("cc"))


def preprocessed(text: str, cc: str) -> str:
    """The C text as the compiler takes it, without comments."""
    command = [cc, "-std=c99", "-E", "-P", "-x", "c", "-"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True, timeout=60).stdout


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_names_add_no_token_to_the_python(text: str) -> None:
    def tokens(model: SensorModel) -> list[str]:
        skipped = {tokenize.COMMENT, tokenize.NL, tokenize.STRING}
        read = tokenize.tokenize(io.BytesIO(python_text(model).encode()).readline)
        return [token.string for token in read if token.type not in skipped]

    assert tokens(named(text, MODELS["seed 3"])) == tokens(MODELS["seed 3"])
