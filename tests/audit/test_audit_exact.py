"""The audit knows no closed form: its reference and its errors are held to those that have one."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from plumbob.engines.audit.reference import certified
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import scenes
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
    families = scenes("cone-pendulum/*,simple-pendulum/*,linear-pendulum/*")
    chosen = [scene for scene in families if "/forced" not in scene.name]  # driven within a step
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
    reference = certified(scene.model, script, 60.0)
    assert reference.until == pytest.approx(duration)
    assert not reference.widths
    motion = scene.observed(reference.course.states, "theta")
    certificate = certificate_of(scene, reference, "theta")[-1]
    for halved in range(4):
        parts = round(period / step) << halved
        run = scene.model.stepped(script, scene.model.integrator, parts)
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


@pytest.mark.parametrize("step", [0.002, 0.001])
def test_sliding_capsule_tends_to_the_limit_of_its_own_contacts(step):
    """Friction that is damping at the rate b below the speed mu g/b lets a body slide mu g/(2 b^2)
    further than Coulomb's: v_0/b less v_0^2/(2 mu g) at v_0 = mu g/b."""
    duration = 0.2
    scene = scene_as_model("capsule-coast/translation", "mujoco/euler+coulomb", step, duration)
    script = scene.script(duration, 0.01)
    reference = certified(scene.model, script, 60.0)
    exact = scene.case.reference.observe(script.times)
    found, _ = measure(scene.case, find_method("mujoco/euler+coulomb"), step)
    left = {n: sum(found.errors[n].model.values()) for n in ("x", "y")}
    velocity = np.array([exact["velocity_x"], exact["velocity_y"]])
    speed = np.linalg.norm(velocity, axis=0)
    braking = (speed[0] - speed[1]) / script.period  # mu g
    further = braking / (2 * rate_of_friction(scene) ** 2)
    for name, along in zip(("x", "y"), velocity[:, 0] / speed[0], strict=True):
        apart = scene.observed(reference.course.states, name)[-1] - exact[name][-1]
        certificate = certificate_of(scene, reference, name)[-1]
        assert certificate < 1e-8
        assert apart == pytest.approx(further * along, abs=certificate + left[name])
        run = scene.model.stepped(script, "euler", round(0.01 / step))
        own = scene.observed(run.states, name)[-1] - exact[name][-1] - apart
        assert own + further * along == pytest.approx(
            found.errors[name].end, abs=certificate + left[name]
        )
        assert further * along > 10 * (certificate + left[name])  # it would be seen


def rate_of_friction(scene):
    """[1/s] at which friction damps slow sliding in the compiled model."""
    data = mujoco.MjData(scene.compiled)
    data.qpos[:], data.qvel[:] = scene.model.start.qpos, scene.model.start.qvel
    mujoco.mj_forward(scene.compiled, data)
    rates = data.efc_KBIP[:, 1]
    normal = set(data.contact.efc_address)
    (rate,) = {round(float(r), 9) for i, r in enumerate(rates) if i not in normal}
    return rate
