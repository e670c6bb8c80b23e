"""The cone pendulum in pymunk: its errors, and the energy that a torque set too early gains."""

from dataclasses import replace

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.cone_pendulum.hamiltonian import ROTATING
from plumbob.reports.judge.verdict import judge

TORQUE = find_method("pymunk/torque")


def test_a_torque_before_the_step_fails():
    """Euler's explicit rule is not the scheme that the method is declared to have."""
    scene = find_scene(ROTATING)
    system = system_of(scene)
    late = replace(TORQUE, settings={"torque": "before"})
    assert judge(measure(case_of(scene), late, 1e-4)[0], system, late).verdict == "off-prediction"
