"""What solvers that choose their steps pay for stiffness, measured beside its prediction."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.errors.stability.adaptive_cost import stiffness_cost
from plumbob.analytic.tableau import CLASSICAL
from plumbob.engines.registry import methods
from plumbob.engines.study.runner import run_study
from plumbob.models.registry import scenes
from plumbob.reports.analyses.analysis import Record
from plumbob.reports.analyses.engines import largest_steps
from plumbob.reports.analyses.engines.largest_steps import SOLVERS, claims, evaluation_rates


def test_dop853_pays_what_stability_asks_and_implicit_solvers_next_to_nothing():
    solvers = methods(",".join(SOLVERS))
    (scene,) = scenes(largest_steps.EQUILIBRIUM)
    short = replace(scene, steps=scene.steps[:1])
    study = run_study((short,), solvers, timed=False, requests=largest_steps.solver_runs)
    found = Record(surprises=(), paid=evaluation_rates(study))
    assert len(found.paid) == 4
    for damping, of in found.paid.items():
        assert of["ode/dop853"] == pytest.approx(of["predicted"], rel=0.02)
        assert max(of["ode/radau"], of["ode/lsoda"]) < 0.05 * damping
    assert all(claim.holds for claim in claims(found))
    # a method whose stability reaches 2.79, not 6.4, is noticed
    fastest = np.array([-1e4 + 0j])
    wrong = {**found.paid[1e4], "predicted": 12.0 * stiffness_cost(CLASSICAL, fastest)}
    assert not all(claim.holds for claim in claims(Record(surprises=(), paid={1e4: wrong})))
