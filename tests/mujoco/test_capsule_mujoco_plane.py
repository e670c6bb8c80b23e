"""MuJoCo's capsule in the plane: turns, spin and a plan against the exact motion."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.mujoco_capsule import METHODS, run

EULER = "euler+coulomb"


@pytest.mark.parametrize("heading", [3.0, -3.0])
def test_a_heading_goes_on_where_its_angle_jumps(heading):
    # turns by 0.52 rad, through half a turn
    rate = 6.0 if heading > 0.0 else -6.0
    turned = scene("capsule-coast/rotation", {"heading": heading, "heading_rate": rate})
    found, _ = measure(case_of(turned), METHODS[EULER], 1e-3)
    assert abs(found.errors["heading"].end) < 0.01


def test_implicitfast_takes_another_step_with_a_lone_body():
    # velocity derivatives of a free body's centripetal forces, which it drops in a tree
    other = replace(
        METHODS["implicitfast+coulomb"],
        settings={
            **METHODS["implicitfast+coulomb"].settings,
            "integrator": "implicit",
        },
    )
    case = scene("capsule-coast/spin")
    found = compiled(case_of(case), other, 1e-3).run().observables["x"]
    same = run("capsule-coast/spin", "implicitfast+coulomb", 1e-3)[1].observables["x"]
    np.testing.assert_allclose(found, same, rtol=0, atol=1e-14)
    lone = run("capsule-coast/spin", "implicitfast+coulomb", 1e-3)[0]
    assert all(error.predicted is None for error in lone.errors.values())
    assert "no error theory" in lone.note
