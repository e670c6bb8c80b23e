"""Collocation against solutions that have a formula: nodes, integrals, and Newton's last step."""

import numpy as np
import pytest

from plumbob.analytic.numerics.collocation import (
    collocate,
    gauss_collocation,
    radau_collocation,
)

# Of the solution's size: some roundings. Newton's method that ends at 1e-12 leaves 1e-13 and more
# at one length or another.
ROUND = 4e-15


@pytest.mark.parametrize("rule", [gauss_collocation(20), radau_collocation(24)])
def test_a_solution_is_exact_at_all_lengths(rule):
    """z' = z^2 from 1 on is 1/(1 - t)."""
    off = []
    for length in np.linspace(0.02, 0.4, 77):

        def rates(states, wanted, length=length):
            return length * states**2, 2.0 * length * states[..., None] if wanted else states

        guess = np.full((len(rule.nodes), 1), length)
        slopes = collocate(rule, rates, np.ones(1), guess, np.ones(1))
        states = 1.0 + rule.integral @ slopes
        off.append(np.abs(states[:, 0] * (1.0 - length * rule.nodes) - 1.0).max())
        ends = 1.0 + rule.weights @ slopes
        off.append(abs(ends[0] * (1.0 - length) - 1.0))
    assert max(off) <= ROUND
