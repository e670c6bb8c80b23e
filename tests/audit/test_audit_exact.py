"""The audit knows no closed form: its reference and its errors are held to those that have one."""

import numpy as np
import pytest

from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.reference import certified
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import matching_scenes
from plumbob.tests.audit.scenes_as_models import scene_as_model

# scene: method, own step [s], duration [s], period [s]
QUICK = {
    "cone-pendulum/rotating-base": ("mujoco/euler", 0.002, 0.5, 0.02),
    "cone-pendulum/unequal-inertia": ("mujoco/rk4", 0.002, 0.1, 0.02),
    "simple-pendulum/free-large": ("mujoco/euler", 0.01, 1.0, 0.1),
    "simple-pendulum/damped-rotating": ("mujoco/implicitfast", 0.01, 1.0, 0.1),
}
LONGEST = 1.0  # [s] of the scenes in the full profile
ROUNDED = 64 * np.finfo(float).eps  # of an angle of a few radians, after some thousand steps


@pytest.mark.parametrize("name", QUICK)
def test_errors_agree_with_those_of_the_study(name):
    method, step, duration, period = QUICK[name]
    assert check(name, method, step, duration, period) < 1e-6


def test_errors_agree_on_every_scene_without_contacts(request):
    families = matching_scenes("cone-pendulum/*,simple-pendulum/*,linear-pendulum/*")
    # driven within a step
    chosen = [scene for scene in families if "/forced" not in scene.name]
    assert len(chosen) > 50
    every = 1 if request.config.getoption("--profile") == "full" else 12
    for scene in chosen[::every]:
        duration = min(scene.duration, LONGEST)
        # Beside an unstable equilibrium every rounding grows, and with it what two methods differ
        # by: the certificate is as large as it must be.
        check(scene.name, "mujoco/rk4", duration / 100, duration, duration / 10)


def check(name, method, step, duration, period):
    """|the audit's error - the study's| <= certificate + model error + rounding, at four steps; the
    certificate [rad]."""
    scene = scene_as_model(name, method, step, duration)
    script = scene.script(duration, period)
    reference = certified(scene.model, script, Allowance(60.0))
    assert reference.until == pytest.approx(duration)
    assert not reference.widths
    motion = scene.observed(reference.course.states, "theta")
    certificate = certificate_of(scene, reference, "theta")[-1]
    for halved in range(4):
        parts = round(period / step) << halved
        run = scene.model.stepped(script, scene.integrator, parts)
        assert not run.why
        error = scene.observed(run.states, "theta")[-1] - motion[-1]
        found, _ = measure(scene.case, find_method(method), period / parts)
        study = found.errors["theta"]
        steps = parts * len(script.controls)
        rounded = study.uncertainty * (1 + 2 * np.sqrt(steps)) + ROUNDED * max(1.0, study.scale)
        allowed = certificate + sum(study.model.values()) + rounded
        assert abs(error - study.end) <= allowed, (name, parts)
    return float(certificate)


def certificate_of(scene, reference, name):
    """How far the two computations of a reference are apart in an observable, so far: (n,)."""
    here = scene.observed(reference.course.states, name)
    there = scene.observed(reference.confirmed_by.states, name)
    return np.asarray(np.maximum.accumulate(np.abs(here - there)))
