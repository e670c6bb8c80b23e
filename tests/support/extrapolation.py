"""Motions integrated with many digits, once, into the records that tests hold closed forms to.

Extrapolation of the modified midpoint rule to order 40 (Gragg 1965, SIAM J. Numer. Anal. 2, 384) in
gmpy2's numbers: an independent method, with neither formula nor arithmetic of what it checks.
"""

import json
from dataclasses import asdict, dataclass

import gmpy2

COLUMNS = 20


def extrapolated(rates, state, step):
    """The state after `step`, by Aitken and Neville's scheme in the square of the substep."""
    table = []
    for k in range(1, COLUMNS + 1):
        row = [midpoint(rates, state, step, 2 * k)]
        for j, before in enumerate(table, start=1):
            ratio = (gmpy2.mpfr(k) / (k - j)) ** 2 - 1
            row.append([x + (x - y) / ratio for x, y in zip(row[-1], before, strict=True)])
        table = row  # row[j] extrapolates the last j + 1 results
    return table[-1]


def midpoint(rates, state, step, count):
    """Gragg's modified midpoint rule in `count` substeps, an even number."""
    h = step / count
    before = state
    now = [x + h * v for x, v in zip(state, rates(state), strict=True)]
    for _ in range(count - 1):
        ahead = [x + 2 * h * v for x, v in zip(before, rates(now), strict=True)]
        before, now = now, ahead
    ends = zip(before, now, rates(now), strict=True)
    return [(x + y + h * v) / 2 for x, y, v in ends]


def states(motion, longest):
    """The state at each of the motion's times, in steps of at most `longest` [s]."""
    rates, state, times = motion
    time = gmpy2.mpfr(0)
    reached = []
    for until in times:
        count = int(gmpy2.ceil((until - time) / longest))
        for _ in range(count):
            state = extrapolated(rates, state, (until - time) / count)
        time = gmpy2.mpfr(until)
        reached.append(state)
    return reached


@dataclass(frozen=True)
class Recorded:
    """A motion's constants, its start, times [s], and the state at each of them in many digits."""

    constants: tuple[float, ...]
    start: tuple[float, ...]
    times: tuple[float, ...]
    states: tuple[tuple[str, ...], ...]


def recorded(file):
    """The motions of a file."""
    table = json.loads(file.read_text("utf-8"))
    return {
        name: Recorded(**{field: tuple(values) for field, values in case.items()})
        for name, case in table.items()
    }


def record(file, motion, longest, digits, bound, shown=lambda _, state: state):
    """Write the states of each motion of a file anew: `shown` of each in so many digits; steps of
    `longest` [s] and of 0.7 times that have to agree within `bound`, relatively."""
    table = {}
    with gmpy2.context(gmpy2.get_context(), precision=200):
        for name, case in recorded(file).items():
            equation = motion(case)
            first = states(equation, longest)
            second = states(equation, 0.7 * longest)
            apart = max(
                float(abs(x - y) / (1 + abs(x)))
                for one, other in zip(first, second, strict=True)
                for x, y in zip(one, other, strict=True)
            )
            assert apart < bound, (name, apart)
            written = [[f"{value:.{digits}g}" for value in shown(equation, x)] for x in second]
            table[name] = {**asdict(case), "states": written}
            print(name, apart, flush=True)
    file.write_text(json.dumps(table, indent=1) + "\n", "utf-8")


def tuples(value):
    """A value of JSON or TOML with tuples for its lists."""
    if isinstance(value, dict):
        return {name: tuples(part) for name, part in value.items()}
    return tuple(map(tuples, value)) if isinstance(value, list) else value
