"""Flight C as text: header, source, and a test with its vectors; and the constants read back from the source."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....sensors.model.sensor_model import SensorModel
from ....sensors.model.serial import model_checksum
from ..apply_parts import head, plain
from .design import Arithmetic, Constant, Constants, Design, Values
from .exact import Ideal
from .twin import FLAGS, channels

LONGEST_PREFIX = 25  # so that a name of C has 31 characters, which C99 tells apart in other files
SHORT = {"gyro": "gyro", "accelerometer": "acc"}
OUTPUT = {"gyro": "rate", "accelerometer": "acceleration"}
MEANING = {
    "signal": "of each sensor",
    "reference": "of the reference of each signal",
    "temperature": "of the temperature of each sensor",
    "temperature_reference": "of its reference; that of the signal again where it has none of its own",
    "built_in_test": "of the built-in test of each sensor",
}
FLAG_MEANING = {
    "BIT": "built-in test is low",
    "RAIL": "a code is at an end of the converter, or beyond",
    "TEMPERATURE": "beyond the range of the model; taken at its end",
    "REFERENCE": "a reference is not plausible",
    "INPUT": "the output is beyond the range of the model",
}
RAISED_BY = {  # flag -> constants, of which one is there where it can be raised
    "BIT": ("GOOD",),
    "RAIL": ("LOWEST",),
    "TEMPERATURE": ("TEMPERATURE_ENDS",),
    "REFERENCE": ("REFERENCE_WINDOW", "TEMPERATURE_WINDOW"),
    "INPUT": ("INPUT_ENDS", "CURVE"),
}


@dataclass(frozen=True, eq=False)
class Unit:
    """One sensor of an export: what it is, what it computes, with which numbers."""

    prefix: str
    model: SensorModel
    ideal: Ideal
    design: Design

    @property
    def how(self) -> Arithmetic:
        """Arithmetic."""
        return self.design.arithmetic


@dataclass(frozen=True, eq=False)
class Vectors:
    """Codes of each channel, outputs and flags, shape (n, k)."""

    codes: Mapping[str, NDArray[np.int64]]
    values: Values
    flags: NDArray[np.uint8]


def prefix(model: SensorModel, how: Arithmetic) -> str:
    """Return the start of all names of a sensor: kind, serial number, condition, arithmetic; 25 letters at most.

    Where there is no serial number, or letters of it had to be changed, a checksum stands in place of it, so that two
    sensors do not have one name.
    """
    parts = [SHORT[model.kind], model.item.serial, model.condition, how.name]
    found = "_".join(word for word in (re.sub(r"[^a-z0-9]+", "_", part.lower()).strip("_") for part in parts) if word)
    if not model.item.serial:
        return "_".join((SHORT[model.kind], model_checksum(model)[-6:], how.name))
    if len(found) <= LONGEST_PREFIX and re.fullmatch(r"[a-z0-9]+", model.item.serial):
        return found
    mark = hashlib.sha256("\0".join(parts).encode("utf-8", "surrogatepass")).hexdigest()[:6]
    return "_".join((SHORT[model.kind], mark, how.name))


def fields(unit: Unit) -> tuple[str, ...]:
    """Return which codes a sensor takes, in the order of the struct."""
    return channels({name: one.values for name, one in unit.design.constants.items()})


# ---- header --------------------------------------------------------------------------------------------------------


def header(stem: str, units: Sequence[Unit], notes: Sequence[str]) -> str:
    """Return the header: types of codes and outputs, flags, and a function a sensor."""
    lines = ["/* True inputs from raw codes; written by inertialcal.", " *"]
    lines += [f" * {line}".rstrip() for line in notes]
    lines += [" */", f"#ifndef {stem.upper()}_H", f"#define {stem.upper()}_H", "", "#include <stdint.h>", ""]
    for unit in units:
        lines += _declared(unit)
    return "\n".join([*lines, f"#endif /* {stem.upper()}_H */", ""])


def _declared(unit: Unit) -> list[str]:
    name, upper, k = unit.prefix, unit.prefix.upper(), len(unit.model.axes)
    scale = f" times 2^{unit.how.bits}" if unit.how.fixed else ""
    lines = ["/* Flags of a reading, one byte an axis. */"]
    raised = [flag for flag in FLAGS if any(table in unit.design.constants for table in RAISED_BY[flag])]
    lines += [f"#define {upper}_{flag} 0x{FLAGS[flag]:02X}U /* {FLAG_MEANING[flag]} */" for flag in raised]
    lines += ["", "/* Raw codes, sensors in the order " + ", ".join(map(plain, unit.model.axes)) + ". */"]
    lines += ["typedef struct", "{"]
    lines += [f"    int32_t {one}[{k}]; /* {MEANING[one]} */" for one in fields(unit)]
    lines += [f"}} {name}_codes;", "", "typedef struct", "{"]
    lines += [f"    {unit.how.output} {OUTPUT[unit.model.kind]}[{k}]; /* [{plain(unit.ideal.unit)}{scale}] */"]
    lines += [f"    uint8_t flags[{k}]; /* 0: all is well */", f"}} {name}_output;", ""]
    lines += ["/* Fill output from codes; return the flags of all axes together. */"]
    return [*lines, f"uint8_t {name}_apply(const {name}_codes *codes, {name}_output *output);", ""]


# ---- source --------------------------------------------------------------------------------------------------------


def source(stem: str, units: Sequence[Unit]) -> str:
    """Return the source: constants and function of each sensor."""
    how = units[0].how
    lines = [f"/* True inputs from raw codes, in {how.name}; see {stem}.h. Written by inertialcal.", " *"]
    lines += [f" * {line}".rstrip() for unit in units for line in [*head(unit.model), ""]]
    lines += [f" * To compile: cc -std=c99 -ffp-contract=off -c {stem}.c", " */", f'#include "{stem}.h"', ""]
    if not how.fixed:
        lines += ["#include <float.h>", "", "#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)"]
        lines += ['#error "the bound holds where each operation is rounded to its own type: FLT_EVAL_METHOD 0"']
        lines += ["#endif", ""]
    lines += _helpers(stem, how, any("CURVE" in unit.design.constants for unit in units))
    for unit in units:
        lines += [*_function(stem, unit), ""]
    return "\n".join(lines)


def _table(prefix: str, name: str, one: Constant) -> list[str]:
    values = one.values
    sizes = "".join(f"[{n}]" for n in values.shape)
    comment = f" /* {plain(one.comment)} */" if one.comment else ""
    start = f"static const {one.ctype} {prefix.upper()}_{name}{sizes} ="
    if values.ndim < 2:
        return [f"{start} {_row(one.ctype, values)};{comment}"]
    rows = [f"    {_row(one.ctype, row)}" + ("," if at < len(values) - 1 else "") for at, row in enumerate(values)]
    return [f"{start}{comment}", "{", *rows, "};"]


def _row(ctype: str, values: Values) -> str:
    if values.ndim == 0:
        return _number(ctype, values.item())
    return "{" + ", ".join(_row(ctype, one) for one in values) + "}"


def _number(ctype: str, value: float) -> str:
    if ctype == "float":
        return f"{np.float32(value)!s}f"
    if ctype == "double":
        return repr(float(value))
    return f"{int(value)}{'U' if ctype == 'uint32_t' else ''}"


def _helpers(stem: str, how: Arithmetic, bent: bool) -> list[str]:
    lines = f"""\
static int32_t {stem}_within(int32_t value, int32_t lowest, int32_t highest)
{{
    const int32_t above = (value < lowest) ? lowest : value;

    return (above > highest) ? highest : above;
}}

static uint32_t {stem}_beyond(int32_t value, int32_t lowest, int32_t highest, uint32_t flag)
{{
    return ((value < lowest) || (value > highest)) ? flag : 0U;
}}
""".split("\n")
    if how.fixed:
        lines += f"""\
/* value / 2^bits, halves away from zero; bits is 1 or more. */
static int64_t {stem}_rounded(int64_t value, uint32_t bits)
{{
    const uint64_t one = 1U;
    const uint32_t below = bits - 1U;
    const uint64_t half = one << below;
    const uint64_t size = (value < 0) ? (uint64_t)(-value) : (uint64_t)value;
    const uint64_t quotient = (size + half) >> bits;
    const int64_t magnitude = (int64_t)quotient;

    return (value < 0) ? -magnitude : magnitude;
}}
""".split("\n")
    if bent:
        kind = how.ctype
        lines += f"""\
static {kind} {stem}_cut({kind} value, {kind} lowest, {kind} highest)
{{
    const {kind} above = (value < lowest) ? lowest : value;

    return (above > highest) ? highest : above;
}}
""".split("\n")
    return lines


def _function(stem: str, unit: Unit) -> list[str]:
    constants, how, k = unit.design.constants, unit.how, len(unit.model.axes)
    name, upper, kind = unit.prefix, unit.prefix.upper(), how.ctype
    changed = "THERMAL" in constants or "CURVE" in constants
    lines = [f"uint8_t {name}_apply(const {name}_codes *codes, {name}_output *output)", "{"]
    tables = [line for word, one in constants.items() for line in _table(unit.prefix, word, one)]
    lines += [*(f"    {line}" for line in tables), ""]
    lines += [f"    {kind} away[{k}];", *([f"    {kind} change[{k}];"] if changed else []), f"    uint32_t flags[{k}];"]
    lines += ["    uint32_t all = 0U;", "", f"    for (uint32_t i = 0U; i < {k}U; i++)", "    {"]
    body = [*_reduction(stem, upper, constants), f"away[i] = ({kind})signal_away;"]
    body += _change(stem, upper, unit) if changed else []
    lines += [f"        {line}".rstrip() for line in [*body, "flags[i] = flag;"]]
    lines += ["    }", f"    for (uint32_t i = 0U; i < {k}U; i++)", "    {"]
    lines += [f"        {line}".rstrip() for line in _output(stem, upper, unit, changed)]
    return [*lines, "    }", "", "    return (uint8_t)all;", "}"]


def _reduction(stem: str, upper: str, constants: Mapping[str, Constant]) -> list[str]:
    ends = f"{upper}_LOWEST, {upper}_HIGHEST"

    def taken(field: str) -> list[str]:
        given = f"codes->{field}[i]"
        return [
            f"flag |= {stem}_beyond({given}, {upper}_LOWEST + 1, {upper}_HIGHEST - 1, {upper}_RAIL);",
            f"const int32_t {field} = {stem}_within({given}, {ends});",
        ]

    def window(field: str, table: str, flag: str) -> str:
        ends = f"{upper}_{table}[i][0], {upper}_{table}[i][1]"
        return f"flag |= {stem}_beyond({field}, {ends}, {upper}_{flag});"

    lines = ["uint32_t flag = 0U;", *taken("signal")]
    if "REFERENCE_WINDOW" in constants:
        lines += [window("codes->reference[i]", "REFERENCE_WINDOW", "REFERENCE"), *taken("reference")]
        lines += ["const int32_t signal_away = signal - reference;"]
    else:
        lines += [f"const int32_t signal_away = signal - {upper}_ORIGIN[i];"]
    if "TEMPERATURE_ENDS" in constants:
        lines += taken("temperature")
        above = "temperature"
        if "TEMPERATURE_WINDOW" in constants:
            lines += [window("codes->temperature_reference[i]", "TEMPERATURE_WINDOW", "REFERENCE")]
            lines += taken("temperature_reference")
            lines += ["const int32_t temperature_away = temperature - temperature_reference;"]
            above = "temperature_away"
        cut = f"{upper}_TEMPERATURE_ENDS[i][0], {upper}_TEMPERATURE_ENDS[i][1]"
        lines += [window(above, "TEMPERATURE_ENDS", "TEMPERATURE")]
        lines += [f"const int32_t warmth = {stem}_within({above}, {cut}) - {upper}_TEMPERATURE_CENTRE[i];"]
    if "GOOD" in constants:
        lines += [f"if (codes->built_in_test[i] < {upper}_GOOD)", "{", f"    flag |= {upper}_BIT;", "}"]
    return lines


def _change(stem: str, upper: str, unit: Unit) -> list[str]:
    """Return the lines for s and q of sensor i."""
    constants, how, kind = unit.design.constants, unit.how, unit.how.ctype
    zero = {"int64_t": "0", "float": "0.0f", "double": "0.0"}[kind]
    lines = [f"{kind} sum = {zero};"]

    def powers(count: int, table: str, variable: str, total: str, bits: str) -> list[str]:
        step = f"({total} + {upper}_{table}[m - 1U]) * {variable}"
        step = f"{stem}_rounded({step}, {upper}_{bits})" if how.fixed else step
        body = [f"    {total} = {step};"]
        if not how.fixed:
            body = [f"    {total} = {total} + {upper}_{table}[m - 1U];", f"    {total} = {total} * {variable};"]
        return [f"for (uint32_t m = {count}U; m > 0U; m--)", "{", *body, "}"]

    if "THERMAL" in constants:
        lines += [f"const {kind} tau = ({kind})warmth;"]
        lines += powers(constants["THERMAL"].values.shape[1], "THERMAL[i]", "tau", "sum", "THERMAL_BITS")
    if "CURVE" in constants:
        if how.fixed:
            lines += [f"const int64_t straight = {stem}_rounded({upper}_SLOPE[i] * away[i], {upper}_SLOPE_BITS);"]
            lines += [f"const int64_t reading = straight + {upper}_READING[i] + sum;"]
        else:
            lines += [f"const {kind} slope = {upper}_SLOPE[i] * away[i];"]
            lines += [f"const {kind} straight = slope + {upper}_READING[i];", f"const {kind} reading = straight + sum;"]
        lines += [
            f"const {kind} lowest = {upper}_CURVE_ENDS[i][0];",
            f"const {kind} highest = {upper}_CURVE_ENDS[i][1];",
        ]
        lines += ["if ((reading < lowest) || (reading > highest))", "{", f"    flag |= {upper}_INPUT;", "}"]
        lines += [f"const {kind} inside = {stem}_cut(reading, lowest, highest);"]
        lines += ["uint32_t side = 0U;", f"if (inside < {zero})", "{", "    side = 1U;", "}", f"{kind} bend = {zero};"]
        near = "inside"
        if how.fixed:
            near = "near"
            lines += [f"const int64_t near = {stem}_rounded(inside, {upper}_CURVE_SHIFT);"]
        lines += powers(constants["CURVE"].values.shape[2], "CURVE[i][side]", near, "bend", "CURVE_BITS")
        lines += ["sum = sum + bend;"]
    return [*lines, "change[i] = sum;"]


def _output(stem: str, upper: str, unit: Unit, changed: bool) -> list[str]:
    constants, how, k, kind = unit.design.constants, unit.how, len(unit.model.axes), unit.how.ctype
    loop = [f"for (uint32_t j = 0U; j < {k}U; j++)", "{"]
    lines = []
    if how.fixed:
        lines += ["int64_t total = 0;", *(["int64_t mixed = 0;"] if changed else [])]
        lines += [*loop, f"    total += {upper}_WEIGHT[i][j] * away[j];"]
        lines += [f"    mixed += {upper}_MIXED[i][j] * change[j];"] if changed else []
        own = f"{upper}_CONSTANT[i]"
        own += f" + change[i] + {stem}_rounded(mixed, {upper}_MIXED_BITS)" if changed else ""
        lines += ["}", f"const int64_t own = {own};", f"total += own * {upper}_SIGNAL_SCALE;"]
        lines += [f"const int64_t value = {stem}_rounded(total, {upper}_OUTPUT_BITS);"]
    else:
        lines += [f"{kind} total = {upper}_CONSTANT[i];"]
        if changed:
            lines += [
                *loop,
                f"    const {kind} part = {upper}_INVERSE[i][j] * change[j];",
                "    total = total + part;",
                "}",
            ]
        lines += [*loop, f"    const {kind} part = {upper}_WEIGHT[i][j] * away[j];", "    total = total + part;", "}"]
        lines += [f"const {kind} largest = {upper}_OWN_WEIGHT[i] * away[i];", f"const {kind} value = largest + total;"]
    if "INPUT_ENDS" in constants:
        ends = f"(value < {upper}_INPUT_ENDS[i][0]) || (value > {upper}_INPUT_ENDS[i][1])"
        lines += [f"if ({ends})", "{", f"    flags[i] |= {upper}_INPUT;", "}"]
    value = "(int32_t)value" if how.fixed else "value"
    lines += [f"output->{OUTPUT[unit.model.kind]}[i] = {value};", "output->flags[i] = (uint8_t)flags[i];"]
    return [*lines, "all |= flags[i];"]


# ---- constants, read back ------------------------------------------------------------------------------------------

_CONSTANT = re.compile(r"static const (\w+) (\w+?)((?:\[\d+\])*) =([^;]*);")
TYPES = {"int32_t": np.int64, "int64_t": np.int64, "uint32_t": np.int64, "float": np.float32, "double": np.float64}


def read_back(text: str, prefix: str) -> Constants:
    """Return the constants of a sensor by the names that follow its prefix, from the text of the source alone.

    Raises
    ------
    DataError
        ``not_read_back`` if a constant is not of the shape that its declaration says.
    """
    found: dict[str, Values] = {}
    bare = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    start = f"{prefix.upper()}_"
    for ctype, word, sizes, value in _CONSTANT.findall(bare):
        if not word.startswith(start):
            continue
        listed = re.sub(r"(?<=[0-9.])[Uf]\b", "", value.replace("{", "[").replace("}", "]"))
        if ctype == "float":  # a decimal goes to float at once, not by way of a double
            listed = re.sub(r"[-\d.][-\d.e+]*", lambda one: json.dumps(float(np.float32(one[0]))), listed)
        values = np.array(json.loads(listed), dtype=TYPES[ctype])
        if values.shape != tuple(int(one) for one in re.findall(r"\d+", sizes)):
            raise DataError(f"{word}: declared {sizes}, holds {values.shape}", code="not_read_back")
        found[word[len(start) :]] = values
    return found


# ---- test ----------------------------------------------------------------------------------------------------------


def test_source(stem: str, units: Sequence[Unit], vectors: Sequence[Vectors]) -> str:
    """Return a program that applies every vector and returns 0 where all outputs and flags are the same to the bit."""
    lines = [f"/* Vectors of {stem}.c, and a program that applies them: 0 where all are met. Written by inertialcal.",
             f" * To run: cc -std=c99 -ffp-contract=off {stem}.c {stem}_test.c -o {stem}_test && ./{stem}_test */",
             "#include <stdio.h>", f'#include "{stem}.h"', ""]  # fmt: skip
    for unit, given in zip(units, vectors, strict=True):
        lines += [f"static const {unit.prefix}_codes {unit.prefix}_given[{len(given.flags)}] = {{"]
        each = [given.codes[one] for one in fields(unit)]
        lines += ["    {" + ", ".join(_row("int32_t", one[n]) for one in each) + "}," for n in range(len(given.flags))]
        lines += ["};", f"static const {unit.prefix}_output {unit.prefix}_expected[{len(given.flags)}] = {{"]
        kind = "int32_t" if unit.how.fixed else unit.how.ctype
        rows = zip(given.values, given.flags, strict=True)
        lines += [f"    {{{_row(kind, one)}, {_row('uint32_t', flags)}}}," for one, flags in rows]
        lines += ["};", ""]
    lines += ["int main(void)", "{", "    int wrong = 0;"]
    for unit, given in zip(units, vectors, strict=True):
        name, out, k = unit.prefix, OUTPUT[unit.model.kind], len(unit.model.axes)
        # no == of floating numbers: neither below nor above is the same, but for a NaN, which fails
        same = [f"output.{out}[i] >= expected->{out}[i]", f"output.{out}[i] <= expected->{out}[i]"]
        lines += [f"    for (int n = 0; n < {len(given.flags)}; n++) {{", f"        {name}_output output;"]
        lines += [f"        const {name}_output *expected = &{name}_expected[n];", "        uint8_t all = 0U;"]
        lines += ["        int same = 1;", f"        const uint8_t returned = {name}_apply(&{name}_given[n], &output);"]
        lines += [f"        for (int i = 0; i < {k}; i++) {{", f"            same = same && {same[0]} && {same[1]};"]
        lines += ["            same = same && output.flags[i] == expected->flags[i];"]
        lines += [
            "            all = (uint8_t)(all | expected->flags[i]);",
            "        }",
            "        if (!same || returned != all) {",
        ]
        lines += [
            f'            (void)printf("{name}: vector %d fails\\n", n);',
            "            wrong = 1;",
            "        }",
            "    }",
        ]
    return "\n".join([*lines, "    return wrong;", "}", ""])
