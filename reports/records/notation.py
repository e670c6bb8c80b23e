"""Numbers, steps, times and costs as text."""

from __future__ import annotations

import math
from typing import Any


def number(value: float, digits: int = 3) -> str:
    """Returns a number with `digits` significant digits: 0.0123, 1.23e-7; a dash if it is not
    finite."""
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    if 1e-3 <= abs(value) < 1e6:
        text = f"{value:.{digits}g}"
        return f"{value:.0f}" if "e" in text else text
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def relative(value: float, digits: int = 2) -> str:
    """Returns a relative error as a percentage: 2.5 %, 0.011 %. An error of 10 or more is a
    multiple of the motion's size: 107×. An error below 1e-5 is a plain number: 4.7e-8."""
    percent = 100.0 * value
    if not math.isfinite(percent) or percent == 0.0:
        return number(percent)
    if value >= 10.0:
        return f"{number(float(f'{value:.{digits}g}'), digits)}×"
    return f"{number(percent, digits)} %" if percent >= 1e-3 else number(value, digits)


def percent(part: float) -> str:
    """Returns a fraction as a whole percentage: 43 %."""
    return f"{100.0 * part:.0f} %"


def short(value: float) -> str:
    """Returns a step or a tolerance with as few digits as it needs, at most four: 1e-4, 2.5e-6,
    0.02."""
    text = f"{value:.4g}"
    if "e" not in text and len(text) <= 5:
        return text
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"


def shortest(value: Any) -> str:
    """Returns a parameter with as few digits as it needs, at most fifteen, which leaves out the
    rounding of double precision: 0.3. Several numbers stand in parentheses: (0.5, 0.4)."""
    if isinstance(value, float):
        return f"{value:.15g}"
    if isinstance(value, (tuple, list)):
        return f"({', '.join(map(shortest, value))})"
    return str(value)


def step(value: float, control: str) -> str:
    """Returns a step with its unit, or a relative tolerance: 1e-4 s, rtol 1e-9."""
    return f"{short(value)} s" if control == "step" else f"rtol {short(value)}"


def seconds(value: float) -> str:
    """Returns a time [s] in the unit that suits its size: s, ms, µs or ns."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        # 1000 of a unit, with three digits, is 1 of the next unit.
        if abs(value) >= 0.9995 * size:
            return f"{number(value / size)} {unit}"
    return f"{number(value / 1e-9)} ns"


def milliseconds(ns: float) -> str:
    """Returns a time [ns] in milliseconds, without the unit: 7.77."""
    return number(1e-6 * ns)


def metres(value: float) -> str:
    """Returns a length [m] with two digits in the unit that suits its size, from m to nm;
    "diverged" if it is not finite."""
    if not math.isfinite(value):
        return "diverged"
    for unit, size in (("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9)):
        if value >= 0.995 * size:  # with two digits
            return f"{float(f'{value / size:.2g}'):g} {unit}"
    return f"{value:.1e} m" if value else "0"


def factor(value: float) -> str:
    """Returns a factor with two significant digits and without an exponent: 9.8, 110, 80,000."""
    return f"{float(f'{value:.2g}'):,g}" if abs(value) < 1e6 else number(value, 2)


def real_time_factor(ns_per_second: float) -> str:
    """Returns the ratio of simulated time to computing time for a cost [ns per simulated second]:
    12.3; a dash if the cost is zero."""
    return number(1e9 / ns_per_second) if ns_per_second > 0 else "–"


def times_real(ns_per_second: float) -> str:
    """Returns the real-time factor for a cost [ns per simulated second] with a multiplication sign:
    12.3×."""
    return f"{real_time_factor(ns_per_second)}×" if ns_per_second > 0 else "–"


def plural(count: int, word: str) -> str:
    """Returns a count with a noun, to which an s is added unless the count is 1: 3 methods."""
    return f"{count} {word}{'' if count == 1 else 's'}"
