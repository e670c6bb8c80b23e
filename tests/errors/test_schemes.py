"""Schemes as data: their names and leads, and a scheme without theory."""

import pickle
from dataclasses import asdict, replace

import pytest

from plumbob.analytic.schemes import Scheme
from plumbob.engines.registry import engines

METHODS = [method for engine in engines().values() for method in engine.methods]


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_every_method_hands_over_a_scheme_that_theory_knows(method):
    scheme = method.scheme
    assert scheme.known or method.engine not in ("mujoco", "ode", "pymunk", "heyoka", "exact")
    assert Scheme(**asdict(scheme)) == scheme
    assert pickle.loads(pickle.dumps(scheme)) == scheme
    assert len({scheme, replace(scheme)}) == 1
