"""Ways to the derivative of a run by one number p of its start, its controls or its parameters.

With a result o(p) of the run, which rounding makes uncertain by R, differences of runs are

    central:  (o(p + eps) - o(p - eps)) / (2 eps) = o' + C eps^2 + R / eps                      (1)
    forward:  (o(p + eps) - o(p)) / eps = o' + C eps + R / eps                                  (2)

and the sum of both errors of a difference of order k is least at

    eps = (R / (k C))^(1 / (k + 1)).                                                            (3)

With the state x in tangent coordinates and the control u of each step, x_n+1 = f(x_n, u_n), and the
derivatives A = f_x and B = f_u of one step, the product of the derivatives of all steps is

    dx_n+1/dp = A_n dx_n/dp + B_n du_n/dp.                                                      (4)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product, repeat
from types import MappingProxyType

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.method import Unsupported
from plumbob.engines.own_motion import NotCertifiable
from plumbob.engines.step_jacobian import state_after_step, step_jacobian
from plumbob.engines.stepper import StepDerivatives, Stepper
from plumbob.engines.tangent_space import TangentSpace

MIN_DIFFERENCES = 4  # least number of differences that show a best one
STEP_NUDGE = 1e-6  # [m, rad, ...] differences of the state for the derivatives of one step
# Differences [m, rad, ...] for a step with contacts. A support that begins to slip is slower than
# STEP_NUDGE, which would reverse its friction.
TOUCHING_NUDGE = 1e-7


@dataclass(frozen=True)
class DifferenceWay:
    """A way to a derivative by the difference of two runs."""

    name: str
    # The upper run's number is shifted by eps, the lower run's by `low` times eps.
    low: float
    order: int  # power of eps in the error of the difference

    def values(self, value: float, eps: float) -> tuple[float, float]:
        """Returns the numbers of the lower run and of the upper run."""
        return value + self.low * eps, value + eps

    def derivative(
        self,
        run: Callable[[float], Array],
        eps: float,
        difference: Callable[[Array, Array], Array],
    ) -> Array:
        """Returns eq. 1 or 2. `run` gives the result for a shift of the number, and `difference`
        the difference of two results."""
        upper = run(eps)
        return difference(upper, run(self.low * eps)) / ((1.0 - self.low) * eps)

    def best_eps(self, truncation: float, rounding: float) -> float:
        """Returns eq. 3 for C and R."""
        return float((rounding / (self.order * truncation)) ** (1.0 / (self.order + 1)))

    def best_of_sweep(self, eps: Sequence[float], errors: Sequence[float]) -> float | None:
        """Returns eq. 3 for the `errors` of differences with falling `eps`. C is taken from the two
        largest differences. R is the root mean square of the errors that C does not explain: each
        of these errors is a random draw of the rounding, which may be small. None if too few
        differences were tried, or if the largest is the best, as for results that are linear in the
        number."""
        sizes = np.array(errors)
        parts = np.array(eps)
        if len(sizes) < MIN_DIFFERENCES or not np.isfinite(sizes).all() or not np.argmin(sizes):
            return None
        powers = parts**self.order
        truncation = float(np.median((sizes / powers)[:2]))
        rounded = sizes > 2.0 * truncation * powers
        if not rounded.any() or not truncation:
            return float(parts[np.argmin(sizes)])
        rounding = math.sqrt(float(np.mean((sizes * parts)[rounded] ** 2)))
        return self.best_eps(truncation, rounding)


CENTRAL, FORWARD = DifferenceWay("central", -1.0, 2), DifferenceWay("forward", 0.0, 1)
DIFFERENCE_WAYS = MappingProxyType({way.name: way for way in (CENTRAL, FORWARD)})


@dataclass(frozen=True)
class RunDerivatives:
    """The derivatives of one run, computed in one way."""

    name: str  # name of the way
    computed: Array | None  # shape (times, coordinates, numbers); None if the way gives none
    eps: float | None = None  # eps of the differences
    why: str = ""  # the way gives none


def steadiest_difference(
    way: DifferenceWay,
    run: Callable[[int, float], Array],
    numbers: Sequence[int],
    difference: Callable[[Array, Array], Array],
    sweep: Sequence[float],
    shape: tuple[int, ...],
) -> RunDerivatives:
    """Returns the derivatives by some `numbers`, of the given shape, and zero by others. Of a
    falling `sweep` of eps, the one is used whose derivatives change least when eps becomes the next
    smaller one. `run` takes the index of a number and its shift, and returns results over time."""
    derivatives = np.zeros((len(sweep), *shape))
    try:
        for (k, eps), number in product(enumerate(sweep), numbers):
            derivatives[k, ..., number] = way.derivative(partial(run, number), eps, difference)
    except (NotCertifiable, Unsupported) as why:
        return RunDerivatives(way.name, None, why=str(why))
    changes = np.linalg.norm(np.diff(derivatives[:, -1], axis=0), axis=(1, 2))
    best = int(np.argmin(changes))
    return RunDerivatives(way.name, derivatives[best], sweep[best])


def product_of_steps(
    steps: Iterable[StepDerivatives], along: Array, changes: Iterable[Array]
) -> Iterator[Array]:
    """Yields eq. 4 after each step, from the derivative `along` of the state at the start and the
    `changes` of each step's control."""
    for (by_state, by_control), change in zip(steps, changes, strict=False):
        along = by_state @ along + by_control @ change
        yield along


def product_by_start_and_controls(
    steps: Iterable[StepDerivatives], size: int, degrees: int, inputs: int, parts: int
) -> Array:
    """Returns eq. 4 for the positions, which are the first `degrees` numbers of a state in tangent
    coordinates, at the ends of periods of `parts` steps. The derivatives are by the `size` numbers
    of the state at the start and by constant additions to the `inputs` controls. The result has the
    shape (periods + 1, degrees, size + inputs)."""
    start = np.eye(size, size + inputs)
    added = repeat(np.eye(inputs, size + inputs, size))
    ends = [start[:degrees]]
    for number, along in enumerate(product_of_steps(steps, start, added), 1):
        if number % parts == 0:
            ends.append(along[:degrees])
    return np.array(ends)


def derivatives_of_steps(
    stepper: Stepper,
    space: TangentSpace,
    state: Array,
    controls: Array,
    nudge: float,
    ends: float = math.inf,
) -> Iterator[StepDerivatives]:
    """Yields the derivatives of each step of a run from a `state` under `controls`, a row for a
    step, by central differences of size `nudge`. Each step begins as in a new stepper. Raises
    NotCertifiable if the run diverges, and from the processor time `ends` [s] on."""
    shifts = nudge * np.eye(controls.shape[1])
    for number, control in enumerate(controls, 1):
        by_state = step_jacobian(stepper, space, state, control, nudge, ends=ends)
        ahead, behind = (
            np.array([state_after_step(stepper, space, state, row) for row in rows])
            for rows in (control + shifts, control - shifts)
        )
        by_control = np.zeros((len(by_state), 0))
        if len(shifts):
            by_control = space.differences(ahead, behind).T / (2.0 * nudge)
        state = state_after_step(stepper, space, state, control)
        if not np.isfinite(state).all():
            raise NotCertifiable(f"its run diverges within {number * stepper.step:g} s")
        yield by_state, by_control
