"""Sensors with their chains that flight C is tried on: published, small, curved, without reference, pulses."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from inertialcal.core.key import Kind
from inertialcal.files.models.flight_c.design import Constants, arithmetic, design
from inertialcal.files.models.flight_c.emit import Unit, fields, header, prefix, read_back, source
from inertialcal.files.models.flight_c.exact import ideal
from inertialcal.sensors.catalogue import flight_unit
from inertialcal.sensors.chain.converter import Chain, Thermometer, pulse_counter
from inertialcal.sensors.model.sensor_model import Item, SensorModel

STRICT = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-pedantic", "-ffp-contract=off"]
UNDEFINED = ["-fsanitize=undefined", "-fno-sanitize-recover=all"]
DEGREES = 180.0 / np.pi
STRONG = 40  # times 0.2 % of full input: the second order of a curve that bends much


def published() -> tuple[SensorModel, Chain]:
    """Return the rate suite, corrected."""
    unit = flight_unit()
    return unit.models["corrected"], unit.chains["flight"]


def curved() -> tuple[SensorModel, Chain]:
    """Return the same with a kink, a second and a third order."""
    model, chain = published()
    bent = replace(
        model,
        scale_factor_asymmetry=np.array([0.01, 0.0, -0.02]),
        second_order=np.array([2e-4, -1e-4, 0.0]) * DEGREES,
        third_order=np.array([-5e-6, 2e-6, 1e-6]) * DEGREES**2,
    )
    return bent, chain


def fixed_reference(
    kind: Kind = "accelerometer", codes: tuple[int, int] = (-32768, 32767)
) -> tuple[SensorModel, Chain]:
    """Return a head with gains, a fixed reference, electronics with a zero over temperature, negative scale factors."""
    chain = Chain(
        ("x", "y"), 10.0 / 65536, codes, unit="m/s^2", scale_factor=np.array([0.4, -0.3]), reference=0.1,
        zero=np.array([[0.01, -0.02], [1e-4, 2e-4], [1e-6, -1e-6]]), gain=np.array([1.5, 2.0]),
        thermometer=Thermometer(np.array([0.02, -0.025]), np.array([0.3, 0.35]), np.array([20.0, 21.0])),
    )  # fmt: skip
    model = SensorModel(
        kind=kind, axes=("x", "y"), scale_factor=np.array([0.4, -0.3]), output_unit="V", item=Item(serial="head 2"),
        matrix=np.array([[[1.01, 0.002], [-0.003, 0.995]]]), bias=np.array([0.01, -0.02]),
        bias_temperature=np.array([[1e-3, -2e-3], [1e-5, 2e-5]]), reference_temperature=np.array([20.0, 22.0]),
        input_range=np.array([[-15.0, 15.0], [-12.0, 16.0]]), temperature_range=(-10.0, 50.0),
    )  # fmt: skip
    return model, chain


def pulses() -> tuple[SensorModel, Chain]:
    """Return a pulse counter of one axis, without temperature, without ends."""
    chain = pulse_counter(("x",), 0.5, "m/s^2", 1.0e4)
    model = SensorModel(
        kind="accelerometer", axes=("x",), scale_factor=np.array([1.0e4]), output_unit="count/s",
        matrix=np.array([[[1.002]]]), bias=np.array([0.01]), second_order=np.array([1e-4]),
        input_range=np.array([[-10.0, 12.0]]),
    )  # fmt: skip
    return model, chain


def tiny() -> tuple[SensorModel, Chain]:
    """Return one axis of a converter so small that every combination of codes can be tried."""
    chain = Chain(
        ("x",), 5.0 / 63, (0, 63), unit="rad/s", scale_factor=30.0, reference="channel",
        thermometer=Thermometer(0.05, -0.3, 22.0), validity_minimum=2.4,
    )  # fmt: skip
    model = SensorModel(
        kind="gyro", axes=("x",), scale_factor=np.array([30.0]), output_unit="V", matrix=np.array([[[1.013]]]),
        bias=np.array([0.001]), bias_temperature=np.array([[1e-5], [2e-7], [3e-9]]),
        reference_temperature=np.array([22.0]), input_range=np.array([[-0.08, 0.09]]), temperature_range=(-15.0, 60.0),
    )  # fmt: skip
    return model, chain


def sensor(axes: int, bits: int, referenced: bool, warm: bool, bent: float) -> tuple[SensorModel, Chain]:
    """Return a gyro of any size: codes of so many bits, with or without reference, temperature and curve.

    The second order of the curve is 0.2 %, -0.1 % and 0.05 % of full input, times ``bent``.
    """
    top, full, names = 2**bits - 1, 2.5 / 30.0 * 0.95, ("x", "y", "z")[:axes]
    meter = Thermometer(0.0264, -0.5042, 25.7) if referenced else Thermometer(0.0264, 2.0, 25.7)
    chain = Chain(
        names, 5.0 / top, (0, top), unit="rad/s", scale_factor=30.0, reference="channel" if referenced else 2.5,
        thermometer=meter if warm else None,
    )  # fmt: skip
    cross = np.array([[0.013, 0.002, -0.004], [0.003, -0.007, 0.006], [-0.005, 0.001, 0.009]])[:axes, :axes]
    model = SensorModel(
        kind="gyro", axes=names, scale_factor=np.full(axes, 30.0), output_unit="V", matrix=(np.eye(axes) + cross)[None],
        bias=np.array([0.001, -0.0021, 0.0007])[:axes], input_range=np.tile([-full, full], (axes, 1)),
    )  # fmt: skip
    if warm:
        powers = np.array([[1e-5, 2e-5, -1e-5], [2e-7, 1e-7, 3e-7], [3e-9, -2e-9, 1e-9]])[:, :axes]
        model = replace(model, bias_temperature=powers, reference_temperature=np.full(axes, 22.0),
                        temperature_range=(-15.0, 60.0))  # fmt: skip
    if bent:
        model = replace(
            model, scale_factor_asymmetry=np.array([0.001, 0.0, -0.002])[:axes],
            second_order=bent * np.array([2e-3, -1e-3, 5e-4])[:axes] / full,
            third_order=min(bent, STRONG / 2) * np.array([-1e-3, 8e-4, 1e-3])[:axes] / full**2,
        )  # fmt: skip
    return model, chain


def strong() -> tuple[SensorModel, Chain]:
    """Return three gyros whose second order is 8 % of full input on one axis, and 4 and 2 % on the others."""
    return sensor(3, 12, True, True, STRONG)


CASES = {"published": published, "curved": curved, "fixed": fixed_reference, "pulses": pulses, "tiny": tiny,
         "strong": strong}  # fmt: skip
FIXED = {"published": "q27", "curved": "q27", "fixed": "q25", "pulses": "q26", "tiny": "q27", "strong": "q25"}


@dataclass(frozen=True, eq=False)
class Case:
    """A sensor, its text, and the constants read from it."""

    unit: Unit
    chain: Chain
    text: str
    constants: Constants


@cache
def case(name: str, how: str) -> Case:
    """Return a case in an arithmetic: ``"fixed"``, ``"float32"``, ``"float64"``, or one by its name."""
    model, chain = CASES[name]()
    chosen = arithmetic(FIXED[name] if how == "fixed" else how)
    function = ideal(model, chain)
    unit = Unit(prefix(model, chosen), model, function, design(function, chosen))
    text = source(unit.prefix, [unit])
    return Case(unit, chain, text, read_back(text, unit.prefix))


def compiled(one: Case, cc: str, folder: Path, text: str = "") -> ctypes.CDLL:
    """Return the code as a library with ``each``, which applies it to n structs."""
    name = one.unit.prefix
    (folder / f"{name}.h").write_text(header(name, [one.unit], ["test"]))
    (folder / f"{name}.c").write_text(text or one.text)
    (folder / "each.c").write_text(
        f'#include "{name}.h"\n'
        f"void each(int n, const {name}_codes *codes, {name}_output *output);\n"
        f"void each(int n, const {name}_codes *codes, {name}_output *output) {{\n"
        f"    for (int i = 0; i < n; i++) (void){name}_apply(&codes[i], &output[i]);\n}}\n"
    )
    library = folder / "flight.so"
    files = [str(folder / f"{name}.c"), str(folder / "each.c")]
    command = [cc, *STRICT, *UNDEFINED, "-shared", "-fPIC", *files, "-o", str(library)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(library))


def by_c(
    one: Case, library: ctypes.CDLL, codes: Mapping[str, NDArray[np.int64]]
) -> tuple[NDArray[np.generic], NDArray[np.uint8]]:
    """Return outputs and flags of the compiled code."""
    k = len(one.unit.model.axes)
    dtype = {"int32_t": np.int32, "float": np.float32, "double": np.float64}[one.unit.how.output]
    packed = np.ascontiguousarray(np.hstack([codes[name] for name in fields(one.unit)]).astype(np.int32))
    layout = np.dtype([("value", dtype, (k,)), ("flags", np.uint8, (k,))], align=True)
    output = np.zeros(len(packed), dtype=layout)
    library.each(len(packed), packed.ctypes.data_as(ctypes.c_void_p), output.ctypes.data_as(ctypes.c_void_p))
    return output["value"], output["flags"]
