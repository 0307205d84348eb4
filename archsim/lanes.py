"""Eight numbers of a table at a time, side by side in one register of the host, without a branch.

A row is looked through in steps of LANES, so its length is a multiple of that: see `padded`. LLVM would make vectors of
a loop by itself, but for rows of any length: with loops before and behind.
"""

from __future__ import annotations

from typing import Any

from archsim.jit import intrinsic, ir, numba, overload

LANES = 8


def padded(length: int) -> int:
    """The least multiple of LANES that is not less than this."""
    return -(-length // LANES) * LANES


def equal_lanes(table: Any, row: Any, first: Any, one: Any, other: Any) -> int:
    """A bit for each of the LANES numbers of table [R, A] from [row, first] on that equals one or the other."""
    return sum(1 << k for k in range(LANES) if table[row, first + k] == one or table[row, first + k] == other)


def least_lane(table: Any, row: Any, first: Any, but: Any) -> int:
    """The least of the LANES numbers of table [R, A] from [row, first] on, but for the lane `but` if there is one."""
    return min(int(table[row, first + k]) for k in range(LANES) if k != but)


_INT64 = ir.IntType(64)
_VECTOR = ir.VectorType(_INT64, LANES)
_MOST = (1 << 63) - 1


def _loaded(context: Any, builder: Any, table_type: Any, table: Any, row: Any, first: Any) -> Any:
    """The lanes from [row, first] on."""
    array = context.make_array(table_type)(context, builder, table)
    width = builder.extract_value(array.shape, 1)
    place = builder.gep(array.data, [builder.add(builder.mul(row, width), first)])
    return builder.load(builder.bitcast(place, _VECTOR.as_pointer()), align=8)


def _everywhere(builder: Any, number: Any) -> Any:
    """The number in all lanes."""
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(nothing, number, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(first, nothing, ir.Constant(ir.VectorType(ir.IntType(32), LANES), None))


@intrinsic
def _equal_lanes(_typing: Any, table: Any, _row: Any, _first: Any, _one: Any, _other: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        lanes = _loaded(context, builder, signature.args[0], *args[:3])
        is_one, is_other = (builder.icmp_signed("==", lanes, _everywhere(builder, n)) for n in args[3:])
        bits = builder.bitcast(builder.or_(is_one, is_other), ir.IntType(LANES))
        return builder.zext(bits, _INT64)

    return numba.int64(table, *[numba.int64] * 4), generate


@intrinsic
def _least_lane(_typing: Any, table: Any, _row: Any, _first: Any, _but: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        lanes = _loaded(context, builder, signature.args[0], *args[:3])
        numbers = ir.Constant(_VECTOR, [ir.Constant(_INT64, k) for k in range(LANES)])
        is_left_out = builder.icmp_signed("==", numbers, _everywhere(builder, args[3]))
        most = ir.Constant(_VECTOR, [ir.Constant(_INT64, _MOST)] * LANES)
        name, kind = f"llvm.vector.reduce.smin.v{LANES}i64", ir.FunctionType(_INT64, [_VECTOR])
        least = numba.core.cgutils.get_or_insert_function(builder.module, kind, name)
        return builder.call(least, [builder.select(is_left_out, most, lanes)])

    return numba.int64(table, *[numba.int64] * 3), generate


@overload(equal_lanes, inline="always")
def _equal_lanes_compiled(table, row, first, one, other):  # without types, as in jit.py
    return lambda table, row, first, one, other: _equal_lanes(table, row, first, one, other)  # type: ignore[call-arg]


@overload(least_lane, inline="always")
def _least_lane_compiled(table, row, first, but):
    return lambda table, row, first, but: _least_lane(table, row, first, but)  # type: ignore[call-arg]
