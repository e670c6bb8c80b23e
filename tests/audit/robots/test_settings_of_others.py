"""Settings for restitution and for a servo on bodies of dm_control and Gymnasium, within what they
promise."""

import mujoco
import numpy as np
import pytest

from plumbob.analytic.errors.contact_models.impacts import (
    IMPACT_IMPEDANCE,
    soft_heights,
    soft_impact,
)
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.bouncing_ball import BouncingBall
from plumbob.engines.registry import method
from plumbob.engines.study.measurement import scheme_of
from plumbob.models.registry import case_of, scene, stability_of
from plumbob.tests.audit.robots.robot_files import folder

STEP = 1e-3  # [s]


def spec_of(package, name):
    if (at := folder(package)) is None:
        pytest.skip(f"{package} is not installed")
    spec = mujoco.MjSpec.from_file(str(at / name))
    spec.option.timestep = STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    return spec


@pytest.mark.parametrize("height", [0.5, 1.3])
@pytest.mark.parametrize("e", [0.3, 0.5, 0.9])
def test_a_free_ball_of_dm_control_rebounds_as_the_ball_s_page_says(e, height):
    """It has six degrees of freedom, friction and a priority of its own. Its e is right to half a
    step of the damper and what gravity takes in the 16 steps of an impact; and its heights are
    those of theory to 5e-3, which its pyramid of friction takes."""
    spec = spec_of("dm_control", "quadruped.xml")
    contact = soft_impact(e, STEP)
    ball = spec.geom("ball")
    ball.solref = contact.solref
    ball.solimp[:2] = [IMPACT_IMPEDANCE, IMPACT_IMPEDANCE]
    radius = ball.size[0]
    spec.body("ball").pos = [5.0, 5.0, height + radius]
    model = spec.compile()
    data = mujoco.MjData(model)
    steps = round(2.0 * np.sqrt(2.0 * height / 9.81) / STEP)
    speed = np.sqrt(2.0 * 9.81 * height)
    heights = []
    for _ in range(steps):
        mujoco.mj_step(model, data)
        heights.append(data.joint("ball_root").qpos[2] - radius)
    dropped = BouncingBall(height, e, 9.81)
    predicted = soft_heights(dropped, Scheme(EULER), STEP, list(range(1, steps + 1)))
    np.testing.assert_allclose(heights, predicted, 0, 5e-3 * height)
    rebound = np.sqrt(max(heights[int(np.argmin(heights)) :]) / height)
    late = e * contact.damping * STEP / 2 + 9.81 * 16 * STEP / speed
    assert rebound == pytest.approx(e, abs=late)


def arm(integrator, step, kv, damping):
    """Gymnasium's reacher with its elbow held by a large armature, and a position actuator in the
    shoulder; and a servo of the inertia that the arm has there."""
    spec = spec_of("gymnasium", "reacher.xml")
    spec.option.timestep = step
    spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    spec.joint("joint1").armature = 1e12
    shoulder = spec.joint("joint0")
    shoulder.damping = [damping, 0.0, 0.0] if np.ndim(shoulder.damping) else damping
    for motor in tuple(spec.actuators):
        spec.delete(motor)
    spec.add_actuator(
        target="joint0",
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        gainprm=[300.0, *[0.0] * 9],
        biasprm=[0.0, -300.0, -kv, *[0.0] * 7],
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:2] = -0.5, 0.7
    mujoco.mj_forward(model, data)
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, inertia, data.qM) if hasattr(data, "qM") else mujoco.mj_fullM(
        model, data, inertia
    )
    changes = {"inertia": float(inertia[0, 0]) - 1.0, "armature": 1.0, "gear": 1.0, "kp": 300.0}
    changes |= {"kv": kv, "damping": damping, "force_limit": 1e3}
    return model, data, case_of(scene("servo/motor-damped", {**changes, "theta": -0.5}))


@pytest.mark.parametrize(("kv", "damping"), [(20.0, 1.0), (0.0, 21.0)])
@pytest.mark.parametrize("integrator", ["euler", "implicitfast"])
def test_a_servo_of_gymnasium_s_reacher_has_the_predicted_error(integrator, kv, damping):
    model, data, case = arm(integrator, 2e-3, kv, damping)
    how = method(f"mujoco/{integrator}")
    counts = np.arange(0, 251, 25)
    angles = [data.qpos[0]]
    for _ in counts[1:]:
        mujoco.mj_step(model, data, nstep=25)
        angles.append(data.qpos[0])
    times = counts * 2e-3
    error = np.array(angles) - case.reference.observe(times)["theta"]
    predicted = case.errors.at_step(scheme_of(case, how), 2e-3, times).errors["theta"]
    assert np.abs(error).max() > 1e-4
    np.testing.assert_allclose(error, predicted, 0, 1e-9)


@pytest.mark.parametrize("integrator", ["euler", "implicitfast"])
def test_its_largest_step_is_the_predicted_one(integrator):
    case = arm(integrator, STEP, 20.0, 1.0)[2]
    theory = stability_of(case)
    (limit, *_) = theory.limits(scheme_of(case, method(f"mujoco/{integrator}")))
    ends = []
    for part in (0.98, 1.02):
        model, data, _ = arm(integrator, part * limit.step, 20.0, 1.0)
        mujoco.mj_step(model, data, nstep=2000)
        ends.append(abs(data.qpos[0]) < 0.5 and not data.warning.number.any())
    assert ends == [True, False]
