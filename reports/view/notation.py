"""How numbers, steps and costs are written on the page."""

from __future__ import annotations

import math


def number(value: float, digits: int = 3) -> str:
    """A number with `digits` significant digits: 0.0123, 1.23e-7, and so on."""
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
    """A relative error: 2.5 %, 0.011 %, 107× from ten times the motion's own size on, and 4.7e-8
    where a percentage would have many zeros."""
    percent = 100.0 * value
    if not math.isfinite(percent) or percent == 0.0:
        return number(percent)
    if value >= 10.0:
        return f"{number(float(f'{value:.{digits}g}'), digits)}×"
    return f"{number(percent, digits)} %" if percent >= 1e-3 else number(value, digits)


def percent(part: float) -> str:
    """A part in whole percents: 43 %."""
    return f"{100.0 * part:.0f} %"


def short(value: float) -> str:
    """A step or a tolerance, with as few digits as it needs, at most four: 1e-4, 2.5e-6, 0.02."""
    text = f"{value:.4g}"
    if "e" not in text and len(text) <= 5:
        return text
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"


def step(value: float, control: str) -> str:
    """A step with its unit, or a relative tolerance."""
    return f"{short(value)} s" if control == "step" else f"rtol {short(value)}"


def seconds(value: float) -> str:
    """A time in s, ms, µs or ns, whichever suits it."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if abs(value) >= size:
            return f"{number(value / size)} {unit}"
    return f"{number(value / 1e-9)} ns"


def metres(value: float) -> str:
    """A length [m] with two digits, in the unit that suits it."""
    if not math.isfinite(value):
        return "diverged"
    for unit, size in (("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9)):
        if value >= 0.9995 * size:
            return f"{float(f'{value / size:.2g}'):g} {unit}"
    return f"{value:.1e} m" if value else "0"


def real_time_factor(ns_per_second: float) -> str:
    """Simulated time over wall time, of a cost [ns per simulated second]."""
    return number(1e9 / ns_per_second) if ns_per_second > 0 else "–"


def times_real(ns_per_second: float) -> str:
    """The same where nothing beside it says what it is: 12.3×."""
    return f"{real_time_factor(ns_per_second)}×" if ns_per_second > 0 else "–"


def plural(count: int, word: str) -> str:
    """A count with its word."""
    return f"{count} {word}{'' if count == 1 else 's'}"
