"""34-digit numbers by gmpy2's MPFR: scalars and arrays that work with numpy's functions.

Each result is rounded once to 113 bits. gmpy2 has wheels for more platforms than numpy-quaddtype.
The operators of gmpy2's type `mpfr` round to the precision of the thread's context, 53 bits by
default. Therefore every `mpfr` stays inside the class `Mpfr`, whose operators use a fixed context.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

import gmpy2
import numpy as np

SIGNIFICAND_BITS = 113  # length of the significand, as in IEEE 754 binary128
_CONTEXT = gmpy2.context(precision=SIGNIFICAND_BITS)
_NUMBER = type(gmpy2.mpfr(0))
# Types that the functions of the context take as arguments.
_SCALARS = frozenset({_NUMBER, float, int, np.float64})


def _raw(value: Any) -> Any:
    """Returns the mpfr, or the array of mpfr, inside an `Mpfr`; anything else unchanged."""
    if type(value) is Mpfr:
        return value.values
    if isinstance(value, np.ndarray) and value.dtype == object:
        return quad(value).values  # the elements of the array are `Mpfr`
    return value


def _of_one(of_number: Callable[[Any], Any]) -> Callable[[Any], Mpfr]:
    """Returns a function of one `Mpfr`, elementwise for arrays, made from a function of one
    mpfr."""
    of_array = np.frompyfunc(of_number, 1, 1)

    def result(number: Any) -> Mpfr:
        """Returns the function of one operand."""
        value = number.values
        return Mpfr(of_number(value) if type(value) is _NUMBER else of_array(value))

    return result


def _of_two(of_numbers: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Mpfr]:
    """Returns a function of two operands, elementwise for arrays, made from a function of two
    numbers. At least one of the operands is an `Mpfr`."""
    of_arrays = np.frompyfunc(of_numbers, 2, 1)

    def result(left: Any, right: Any) -> Mpfr:
        """Returns the function of two operands."""
        a = _raw(left)
        b = _raw(right)
        if type(a) in _SCALARS and type(b) in _SCALARS:
            return Mpfr(of_numbers(a, b))
        return Mpfr(of_arrays(a, b))

    return result


def _compared(of_numbers: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """Returns a comparison of `Mpfr`, made from a comparison of numbers. Comparisons are exact in
    any context."""
    return lambda one, other: of_numbers(_raw(one), _raw(other))


def _signed(size: Any, sign: Any) -> Any:
    """Returns the magnitude of `size` with the sign of `sign`."""
    size = _CONTEXT.abs(size)
    return _CONTEXT.minus(size) if gmpy2.is_signed(sign) else size


_UNARY: Mapping[str, Callable[[Any], Mpfr]] = MappingProxyType(
    {
        "absolute": _of_one(_CONTEXT.abs),
        "negative": _of_one(_CONTEXT.minus),
        "sqrt": _of_one(_CONTEXT.sqrt),
        "sin": _of_one(_CONTEXT.sin),
        "cos": _of_one(_CONTEXT.cos),
        "exp": _of_one(_CONTEXT.exp),
        "tanh": _of_one(_CONTEXT.tanh),
        "floor": _of_one(_CONTEXT.floor),
    }
)
_BINARY: Mapping[str, Callable[[Any, Any], Any]] = MappingProxyType(
    {
        "add": _of_two(_CONTEXT.add),
        "subtract": _of_two(_CONTEXT.sub),
        "multiply": _of_two(_CONTEXT.mul),
        "divide": _of_two(_CONTEXT.div),
        "power": _of_two(_CONTEXT.pow),
        "arctan2": _of_two(_CONTEXT.atan2),
        "minimum": _of_two(_CONTEXT.minnum),
        "maximum": _of_two(_CONTEXT.maxnum),
        "copysign": _of_two(_signed),
        "less": _compared(operator.lt),
        "less_equal": _compared(operator.le),
        "greater": _compared(operator.gt),
        "greater_equal": _compared(operator.ge),
        "equal": _compared(operator.eq),
        "not_equal": _compared(operator.ne),
    }
)
# These functions of numpy rearrange numbers without computing.
_MOVES = frozenset(
    {np.append, np.broadcast_arrays, np.concatenate, np.diag, np.ndim, np.ravel, np.roll}
    | {np.shape, np.stack, np.swapaxes, np.where}
)


class Mpfr:
    """One 34-digit number, or an array of them.

    It has those operators and attributes of numpy's arrays that exact solutions use.
    """

    __slots__ = ("values",)

    def __init__(self, values: Any) -> None:
        self.values = values  # an mpfr, or an array of mpfr with dtype object

    def __array_ufunc__(self, function: Any, method: str, *operands: Any, **how: Any) -> Any:
        rules: Mapping[str, Any] = _UNARY if len(operands) == 1 else _BINARY
        if method != "__call__" or how or function.__name__ not in rules:
            return NotImplemented
        return rules[function.__name__](*operands)

    def __array_function__(self, function: Any, kinds: Any, parts: Any, how: Any) -> Any:
        if function not in _MOVES:
            return NotImplemented
        return _wrapped(function(*_unwrapped(parts), **how))

    __add__ = _BINARY["add"]
    __sub__ = _BINARY["subtract"]
    __mul__ = _BINARY["multiply"]
    __truediv__ = _BINARY["divide"]
    __pow__ = _BINARY["power"]
    __radd__ = __add__
    __rmul__ = __mul__
    __lt__ = _BINARY["less"]
    __le__ = _BINARY["less_equal"]
    __gt__ = _BINARY["greater"]
    __ge__ = _BINARY["greater_equal"]
    __eq__ = _BINARY["equal"]
    __ne__ = _BINARY["not_equal"]
    __abs__ = _UNARY["absolute"]
    __neg__ = _UNARY["negative"]
    # For an array of dtype object, numpy calls these methods of its elements.
    sqrt = _UNARY["sqrt"]
    sin = _UNARY["sin"]
    cos = _UNARY["cos"]
    arctan2 = _BINARY["arctan2"]

    def __rsub__(self, other: Any) -> Any:
        return _BINARY["subtract"](other, self)

    def __rtruediv__(self, other: Any) -> Any:
        return _BINARY["divide"](other, self)

    def __hash__(self) -> int:
        return hash(self.values)

    def __float__(self) -> float:
        return float(self.values)

    def __bool__(self) -> bool:
        return bool(self.values)

    def __repr__(self) -> str:
        return str(self.values)

    def __len__(self) -> int:
        return len(self.values)

    def __iter__(self) -> Iterator[Mpfr]:
        return map(Mpfr, self.values)

    def __getitem__(self, at: Any) -> Mpfr:
        return Mpfr(self.values[at])

    def __setitem__(self, at: Any, value: Any) -> None:
        self.values[at] = quad(value).values

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape, as for numpy's arrays; () for one number."""
        return np.shape(self.values)

    @property
    def ndim(self) -> int:
        """Number of dimensions, as for numpy's arrays; 0 for one number."""
        return np.ndim(self.values)

    @property
    def size(self) -> int:
        """Count of numbers."""
        return np.size(self.values)

    def reshape(self, *shape: Any) -> Mpfr:
        """Returns the numbers in another shape, as numpy's method does."""
        return Mpfr(self.values.reshape(*shape))

    def copy(self) -> Mpfr:
        """Returns a copy; assigning to its elements leaves the original unchanged."""
        return Mpfr(self.values.copy())

    def any(self) -> bool:
        """Returns whether at least one number is not zero."""
        return bool(np.any(self.values != 0))

    def sum(self) -> Mpfr:
        """Returns the sum of all numbers; there must be at least one."""
        total, *others = np.ravel(self.values)
        for number in others:
            total = _CONTEXT.add(total, number)
        return Mpfr(total)


def _unwrapped(part: Any) -> Any:
    """Returns an argument with mpfr in place of `Mpfr`, also inside lists and tuples."""
    return list(map(_unwrapped, part)) if isinstance(part, (list, tuple)) else _raw(part)


def _wrapped(result: Any) -> Any:
    """Returns a result with `Mpfr` in place of mpfr, also inside lists and tuples."""
    if isinstance(result, (list, tuple)):
        return type(result)(map(_wrapped, result))
    inside = isinstance(result, np.ndarray) and result.dtype == object
    return Mpfr(result) if inside or type(result) is _NUMBER else result


def _number(value: Any) -> Any:
    """Returns one number as an mpfr, exactly."""
    return value.values if type(value) is Mpfr else gmpy2.mpfr(value, SIGNIFICAND_BITS)


_NUMBERS = np.frompyfunc(_number, 1, 1)
PI: Any = Mpfr(_CONTEXT.const_pi())


def quad(value: Any) -> Any:
    """Returns numbers as 34-digit numbers of the same shape, exactly."""
    return value if type(value) is Mpfr else Mpfr(_NUMBERS(value))


def double(value: Any) -> Any:
    """Returns 34-digit numbers rounded to double: a float for a scalar, else an array."""
    raw = _raw(value)
    if isinstance(raw, (float, _NUMBER)):
        return float(raw)
    return np.asarray(raw).astype(np.float64)
