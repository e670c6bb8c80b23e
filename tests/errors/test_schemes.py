"""Schemes as data: their names and leads, and a scheme without theory."""

import pickle
from dataclasses import asdict, replace

import pytest

from plumbob.analytic.schemes import Scheme
from plumbob.engines.registry import engines
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.verdict import judge

METHODS = [method for engine in engines().values() for method in engine.methods]


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_every_method_hands_over_a_scheme_that_theory_knows(method):
    scheme = method.scheme
    assert scheme.known or method.engine not in ("mujoco", "ode", "pymunk", "heyoka", "exact")
    assert Scheme(**asdict(scheme)) == scheme
    assert pickle.loads(pickle.dumps(scheme)) == scheme
    assert len({scheme, replace(scheme)}) == 1


@pytest.mark.parametrize("name", ["cone-pendulum/rotating-base", "simple-pendulum/free-large"])
def test_an_unknown_scheme_says_so_in_one_line(name):
    case, how = case_of(find_scene(name)), find_method("ode/rk4")
    known, _ = measure(case, how, 1e-3)
    assert known.note == ""
    # the run is RK4's, but the method says that it is something else
    other = replace(find_method("mujoco/rk4"), scheme=Scheme("velocity-verlet"))
    found, _ = measure(case, other, 1e-3)
    assert found.status == "done"
    assert found.note == "no error theory for the scheme 'velocity-verlet'"
    assert not any(error.predicted for error in found.errors.values())
    assert judge(found, case.system, other).reason == found.note
