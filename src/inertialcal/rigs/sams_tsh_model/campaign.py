"""The ground model of the simulated head as its engineer writes it into campaign.toml."""

from __future__ import annotations

from ...core.axes import AXES
from ...core.estimate import Array
from ..sams_tsh.setup import GAINS, REFERENCE_TEMPERATURE, UG, Drawing, Head


def model_text(head: Head, model: Drawing) -> str:
    """Return the tables of the ground model in campaign.toml."""
    pairs = [(i, j) for i in range(3) for j in range(3) if i != j]
    cross = ", ".join(f"{AXES[i]}{AXES[j]} = {_texts(model.cross[:, i, j], 'rad')}" for i, j in pairs)
    head_lines = (
        f'[sensors.head.chain.ground]\nreference_temperature = "{REFERENCE_TEMPERATURE:g} degC"\n'
        f'source = "simulated: made on the ground"\nmisalignment = {{ {cross} }}\n'
    )
    return "\n".join([head_lines, *(_at_gain(at, head, model) for at in range(len(GAINS)))])


def _at_gain(at: int, head: Head, model: Drawing) -> str:
    bias = _each([_texts(model.bias[:, i] / UG, "ug") for i in range(3)])
    scale = _each([_texts(model.scale[at, :, i], "V/g") for i in range(3)])
    zero = _each([f'"{1e6 * value:.6g} uV"' for value in head.zero[at]])
    return f"[sensors.head.chain.ground.gains.{GAINS[at]:g}]\nbias = {bias}\nscale_factor = {scale}\nzero = {zero}\n"


def _texts(coefficients: Array, unit: str) -> str:
    """Return a polynomial as the campaign file has it."""
    units = [unit, *(f"{unit}/degC" + (f"^{power}" if power > 1 else "") for power in range(1, len(coefficients)))]
    return "[" + ", ".join(f'"{value:.12g} {one}"' for value, one in zip(coefficients, units, strict=True)) + "]"


def _each(texts: list[str]) -> str:
    return "{ " + ", ".join(f"{axis} = {text}" for axis, text in zip(AXES, texts, strict=True)) + " }"
