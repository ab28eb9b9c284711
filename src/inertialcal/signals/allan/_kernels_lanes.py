"""Sums of squared differences over eight lanes at once, as LLVM instructions.

Left to itself, LLVM fills but half of the widest registers of a processor (it prefers 256 bits to 512); vectors written
out it takes as they are, and splits them where registers are narrower. These loops are all of the time that a long
record takes, and half again as fast so.

Streams start ``k m`` points after a starting point, for each k of ``streams``; a term is a weighted sum of them. Whole
numbers are summed as such, and only squares are rounded.

Compiled code is kept on disk by the date of the file that calls it: change this one, and touch ``_kernels.py``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import intrinsic

LANES = 8
CHAINS = 4  # sums that run side by side, as each addition waits for the one before
STEP = LANES * CHAINS  # starting points that one round takes at most: their number must be a multiple
REORDERED = ("reassoc", "contract", "nsz")

Weights = tuple[int, ...]


def squares(streams: Sequence[int], terms: Sequence[Weights]) -> Any:
    """Return a compiled function (P, start, m, count) -> the sum of the squares of each term over ``count`` points.

    Parameters
    ----------
    streams : sequence of int
        How many windows after the starting point each stream lies.
    terms : sequence of tuple of int
        Weights of the streams in each term: at most four terms.
    """
    side_by_side = CHAINS // len(terms)

    @intrinsic
    def found(_: Any, p: Any, start: Any, m: Any, count: Any) -> Any:
        """Check nothing: ``count`` is a multiple of STEP, and all streams lie inside P."""
        sums_type: Any = types.UniTuple
        signature = sums_type(types.float64, len(terms))(p, types.intp, types.intp, types.intp)

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            array = signature.args[0]
            points = context.make_array(array)(context, builder, arguments[0]).data
            bases = [_moved(builder, points, arguments[1], arguments[2], k) for k in streams]
            sums = _loop(builder, bases, arguments[3], terms, side_by_side, array.dtype == types.float64)
            return context.make_tuple(builder, signature.return_type, sums)

        return signature, code

    return found


def _moved(builder: Any, points: Any, start: Any, m: Any, k: int) -> Any:
    return builder.gep(points, [builder.add(start, builder.mul(m, ir.Constant(m.type, k)))])


def _loop(
    builder: Any, bases: Sequence[Any], count: Any, terms: Sequence[Weights], side_by_side: int, is_float: bool
) -> list[Any]:
    """Write the loop over starting points, and return the sum of each term."""
    index, double = count.type, ir.DoubleType()
    zero = ir.Constant(ir.VectorType(double, LANES), [0.0] * LANES)
    before = builder.block
    body, after = builder.append_basic_block("body"), builder.append_basic_block("after")
    builder.cbranch(builder.icmp_signed(">", count, ir.Constant(index, 0)), body, after)
    builder.position_at_end(body)
    i = builder.phi(index)
    chains = [builder.phi(zero.type) for _ in range(len(terms) * side_by_side)]
    added: list[Any] = []
    for lane in range(side_by_side):
        at = builder.add(i, ir.Constant(index, lane * LANES))
        values = [_vector(builder, base, at) for base in bases]
        for weights in terms:
            d = _weighted(builder, values, weights, is_float)
            d = d if is_float else builder.sitofp(d, zero.type)
            square = builder.fmul(d, d, flags=REORDERED)
            added.append(builder.fadd(chains[len(added)], square, flags=REORDERED))
    after_it = builder.add(i, ir.Constant(index, side_by_side * LANES))
    builder.cbranch(builder.icmp_signed("<", after_it, count), body, after)
    i.add_incoming(ir.Constant(index, 0), before)
    i.add_incoming(after_it, body)
    builder.position_at_end(after)
    ends = [builder.phi(zero.type) for _ in chains]
    for chain, more, end in zip(chains, added, ends, strict=True):
        for place in (chain, end):
            place.add_incoming(zero, before)
            place.add_incoming(more, body)
    return [_across(builder, ends[k :: len(terms)]) for k in range(len(terms))]


def _vector(builder: Any, base: Any, at: Any) -> Any:
    pointer = builder.gep(base, [at])
    wide = ir.VectorType(pointer.type.pointee, LANES)
    return builder.load(builder.bitcast(pointer, wide.as_pointer()), align=8)


def _weighted(builder: Any, values: Sequence[Any], weights: Weights, is_float: bool) -> Any:
    """Return the weighted sum of vectors; those of weight 1 come first, so that the others are added by one step."""
    total = None
    for weight, value in sorted(zip(weights, values, strict=True), key=lambda pair: pair[0] != 1):
        if not weight:
            continue
        if total is None:
            total = value  # there is one of weight 1
            continue
        factor = ir.Constant(value.type, [float(weight) if is_float else weight] * LANES)
        if is_float:
            total = builder.fadd(total, builder.fmul(factor, value, flags=REORDERED), flags=REORDERED)
        else:
            total = builder.add(total, builder.mul(factor, value))
    return total


def _across(builder: Any, vectors: Sequence[Any]) -> Any:
    """Return the sum over the lanes of all vectors."""
    total = vectors[0]
    for vector in vectors[1:]:
        total = builder.fadd(total, vector, flags=REORDERED)
    lanes = [builder.extract_element(total, ir.Constant(ir.IntType(32), k)) for k in range(LANES)]
    found = lanes[0]
    for lane in lanes[1:]:
        found = builder.fadd(found, lane)
    return found
