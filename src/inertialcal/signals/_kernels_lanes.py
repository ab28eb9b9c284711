"""Eight doubles as one value, for loops of kernels that a compiler does not widen by itself.

Compiled, the eight lie in one register of the processor, or in two or four where it has none so wide; sums, differences
and products of them may be contracted. Without the compiler the same loops run on arrays of eight.
"""

# What numba lets one extend it by has no types.
# mypy: disable-error-code="no-untyped-call, untyped-decorator, call-arg, attr-defined"
from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.datamodel import PrimitiveModel
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, overload, register_model

from ..core.estimate import Array

LANES = 8
ALIGNED = 64  # bytes: eight doubles that start there lie on one line of a cache
_REGISTER = ir.VectorType(ir.DoubleType(), LANES)


def eight(x: float) -> Array:
    """Return eight times a number."""
    return np.full(LANES, x)


def load(a: Array, i: int) -> Array:
    """Return the eight values of a contiguous array from place i on; they must be there."""
    return a[i : i + LANES].copy()


def store(a: Array, i: int, values: Array) -> None:
    """Set the eight values of a contiguous array from place i on; they must be there."""
    a[i : i + LANES] = values


def times(a: Array, b: Array) -> Array:
    """Return the product of eight and eight, rounded by itself whatever is done with it."""
    return a * b


def aligned(n: int) -> Array:
    """Return room for n doubles that starts on a line of a cache."""
    room = np.empty(n + LANES)
    first = -room.ctypes.data % ALIGNED // room.itemsize
    return room[first : first + n]


class _Eight(types.Type):
    def __init__(self) -> None:
        super().__init__("eight")


@register_model(_Eight)
class _Model(PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _REGISTER)


_eight = _Eight()


def _enter(sign: Callable[[Any, Any], Any], instruction: str) -> None:
    """Let an operator of eight and eight be an instruction."""

    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            return signature(_eight, *args) if args == (_eight, _eight) else None

    infer_global(sign)(Template)

    @lower_builtin(sign, _eight, _eight)
    def lower(context: Any, builder: Any, kinds: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*args, flags=("contract",))


_enter(operator.add, "fadd")
_enter(operator.sub, "fsub")
_enter(operator.mul, "fmul")


def _place(context: Any, builder: Any, kind: Any, array: Any, i: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [i]), _REGISTER.as_pointer())


@intrinsic
def _spread(context: Any, x: Any) -> Any:
    def lower(context: Any, builder: Any, kinds: Any, args: Any) -> Any:
        nothing, index = ir.Constant(_REGISTER, ir.Undefined), ir.IntType(32)
        first = builder.insert_element(nothing, args[0], ir.Constant(index, 0))
        return builder.shuffle_vector(first, nothing, ir.Constant(ir.VectorType(index, LANES), [0] * LANES))

    return signature(_eight, types.float64), lower


@intrinsic
def _load(context: Any, a: Any, i: Any) -> Any:
    def lower(context: Any, builder: Any, kinds: Any, args: Any) -> Any:
        return builder.load(_place(context, builder, kinds.args[0], *args), align=a.dtype.bitwidth // 8)

    return signature(_eight, a, types.intp), lower


@intrinsic
def _times(context: Any, a: Any, b: Any) -> Any:
    def lower(context: Any, builder: Any, kinds: Any, args: Any) -> Any:
        return builder.fmul(*args)

    return signature(_eight, _eight, _eight), lower


@intrinsic
def _store(context: Any, a: Any, i: Any, values: Any) -> Any:
    def lower(context: Any, builder: Any, kinds: Any, args: Any) -> Any:
        builder.store(args[2], _place(context, builder, kinds.args[0], *args[:2]), align=a.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return signature(types.void, a, types.intp, _eight), lower


overload(eight)(lambda x: lambda x: _spread(x))  # noqa: PLW0108 - an intrinsic is no function
overload(load)(lambda a, i: lambda a, i: _load(a, i))  # noqa: PLW0108 - an intrinsic is no function
overload(times)(lambda a, b: lambda a, b: _times(a, b))  # noqa: PLW0108 - an intrinsic is no function
overload(store)(lambda a, i, values: lambda a, i, values: _store(a, i, values))  # noqa: PLW0108 - an intrinsic is no function
