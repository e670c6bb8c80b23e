"""The largest step that an audit says: what sets it, what is no instability, and what raises it."""

import json
import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.options import integrator_number
from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit import stability as stability_module
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.stability import (
    LEAST,
    LOST_GROWTH,
    MARGIN,
    AuditedMotion,
    check_below,
    largest_excess,
    largest_steps,
    limit_of_method,
)
from plumbob.engines.own_motion import Start
from plumbob.engines.step_jacobian import state_at_rest
from plumbob.reports.cli import main
from plumbob.tests.audit.scenes_as_models import compiled

# A forearm whose inertia about the elbow is its armature; the upper arm hardly moves with it.
ARM = """
<mujoco model="arm">
  <option timestep="{step}" integrator="{integrator}" gravity="0 0 0"><flag {flag}/></option>
  <default><geom size=".02" contype="0" conaffinity="0"/></default>
  <worldbody>
    <body><joint name="shoulder" axis="0 1 0" stiffness="1"/><geom size=".1" mass="50"/>
      <body pos=".2 0 0"><joint name="elbow" axis="0 1 0" armature="{armature}" {joint}/>
        <geom mass=".001"/></body></body>
  </worldbody>
  {more}
  <keyframe><key qpos="0 .1"/></keyframe>
</mujoco>
"""
INERTIA, KP = 0.01, 2000.0
RATE = math.sqrt(KP / INERTIA)  # [1/s] of the elbow
DRIVE = '<actuator><position name="drive" joint="elbow" kp="2000"/></actuator>'
DRIVEN = "joint elbow, actuator drive kp 2000 on 0.01 kg m²"
# A limit is bisected to 2 %, from below; RK4 grows by the margin 0.8 % beyond where |R(z)| = 1.
WITHIN = 0.02
POLE = """
<mujoco model="pole">
  <option timestep="0.02"/>
  <worldbody><body><joint axis="0 1 0"/><geom size=".02" pos="0 0 .1"/></body></worldbody>
</mujoco>
"""
# A ball that reaches the floor after 3 ms, slowly; refsafe would soften its contact to two steps.
DROP = """
<mujoco model="drop">
  <option timestep="0.0005"><flag refsafe="disable"/></option>
  <worldbody><geom name="floor" type="plane" size="1 1 .1" solref=".002 1"/>
    <body pos="0 0 .10005"><joint name="fall" type="slide" axis="0 0 1"/>
      <geom name="ball" size=".1" solref=".002 1"/></body></worldbody>
</mujoco>
"""


def arm(
    more=DRIVE,
    joint="",
    step=0.001,
    integrator="Euler",
    armature=INERTIA,
    flag='energy="disable"',
):
    return ARM.format(
        more=more, joint=joint, step=step, integrator=integrator, armature=armature, flag=flag
    )


def course(text, duration=0.3, control="rest"):
    """A model along its motion at steps sixteen times smaller than its own."""
    model = own_model(compiled(text), "model", Start(0 if "<key " in text else None))
    motion = script(model, control, duration)
    parts = 16 * round(motion.period / model.step)
    return AuditedMotion(model, motion, model.stepped(motion, "implicitfast", parts).states)


@pytest.mark.parametrize(
    ("integrator", "times"), [("euler", 2.0), ("rk4", math.sqrt(8.0)), ("implicitfast", 2.0)]
)
def test_an_oscillator_goes_where_theory_says(integrator, times):
    """Semi-implicit Euler beyond h omega = 2, RK4 beyond the root of 8."""
    limit = limit_of_method(course(arm()), integrator)
    assert limit.confirmed
    assert limit.largest_step == limit.predicted
    assert limit.largest_step == pytest.approx(times / RATE, rel=WITHIN)
    assert limit.first == DRIVEN


FILTER = (
    '<actuator><general name="drive" joint="elbow" dyntype="filter" dynprm=".001"/></actuator>'
)


@pytest.mark.parametrize(
    ("more", "joint", "integrator", "first", "limit"),
    [
        (
            "",
            'stiffness="2000"',
            "euler",
            "joint elbow, stiffness 2000 on 0.01 kg m²",
            2 / RATE,
        ),
        (
            "",
            'damping="20"',
            "rk4",
            "joint elbow, damping 20 on 0.01 kg m²",
            2.785 * INERTIA / 20,
        ),
        (
            '<actuator><velocity name="brake" joint="elbow" kv="20"/></actuator>',
            "",
            "euler",
            "joint elbow, actuator brake kv 20 on 0.01 kg m²",
            2 * INERTIA / 20,
        ),
        (FILTER, "", "euler", "activation of actuator drive", 0.002),
    ],
)
def test_what_goes_first_has_its_name(more, joint, integrator, first, limit):
    found = limit_of_method(course(arm(more, joint, step=0.0006)), integrator)
    assert found.largest_step == pytest.approx(limit, rel=WITHIN)
    assert found.confirmed
    assert found.first == first


def test_growth_of_the_motion_itself_is_no_instability():
    """A pole on its end falls e-fold in a tenth of a second, at any step."""
    on = course(POLE, 2.0)
    at = on.points[0]
    step = on.model.step
    for integrator in on.model.steppable:
        jacobian = on.jacobian(at, at.state, integrator, step)
        assert largest_excess(jacobian, at.rates, step) <= 1.0 + MARGIN
        assert largest_excess(jacobian, 0.0 * at.rates, step) > 1.0 + MARGIN
        assert on.growth(integrator, step, on.script.start, 0, 2.0) > LOST_GROWTH
        assert not on.lost(integrator, step)
    assert not largest_steps(on.model, on.script, on.states, Allowance()).unstable


def test_a_limit_from_the_start_alone_misses_the_contact():
    on = course(DROP)
    first = limit_of_method(replace(on, states=on.states[:1]), "euler")
    assert first.predicted is None
    limit = limit_of_method(on, "euler")
    assert limit.largest_step == limit.predicted
    assert limit.confirmed
    assert limit.first == "joint fall, contact floor – ball"


@pytest.mark.parametrize(("text", "at"), [(POLE, 0.05), (DROP, 1e-4)])
def test_a_state_of_rest_is_left_as_it_is(text, at):
    """A pole on its end, which falls from anywhere else, and a ball that lies on the floor."""
    on = course(text, 0.04)
    point = on.points[0]
    for step in (on.model.step, 3.0 * on.model.step):
        stepper = on.model.function_stepper("euler", step)
        rest = state_at_rest(stepper, on.space, np.array([-at, 0.0]), point.control)
        nudged = on.growth("euler", step, rest, 0, LEAST * step)
        growing = largest_excess(on.jacobian(point, rest, "euler", step), np.zeros(2), step)
        assert (growing > 1.0 + MARGIN, nudged > LOST_GROWTH) == (text is POLE, text is POLE)
        place, rate = rest
        assert rate == pytest.approx(0.0, abs=1e-8)
        assert place == pytest.approx(0.0, abs=1e-8) if text is POLE else place < -5e-5


def test_a_step_that_loses_the_motion_is_not_said_to_hold(monkeypatch):
    """Where Jacobians show no limit, or one that is too high, nudged runs tell where it is."""
    on = course(arm())
    for factor in (1.4, math.inf):
        shown = factor * 2.0 / RATE
        monkeypatch.setattr(
            stability_module, "magnifies", lambda on, at, of, step, s=shown: step > s
        )
        limit = limit_of_method(on, "euler")
        assert limit.confirmed
        assert limit.largest_step != limit.predicted
        assert limit.largest_step == pytest.approx(2.0 / RATE, rel=0.11)
        assert limit.why.startswith("by nudged runs")


# Two links driven against the limit of the first one's joint: at steps from 13.4 ms on, their state
# of rest is unstable, and they shake alike whatever the nudge.
LINKS = """
<mujoco model="links">
  <option timestep="0.005" integrator="implicit"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <worldbody><body>
    <joint name="shoulder" axis="0 1 0" damping="0.1" range="-1 1"/>
    <geom type="capsule" fromto="0 0 0 0.218 0 0" size=".03" mass="2.41"/>
    <body pos="0.218 0 0">
      <joint name="elbow" axis="0 1 0" damping="0.166"/>
      <geom type="capsule" fromto="0 0 0 0.249 0 0" size=".02" mass="1.23"/></body>
  </body></worldbody>
  <actuator><position joint="shoulder" kp="374" kv="0.836"/>
    <position joint="elbow" kp="135" dampratio="1"/></actuator>
</mujoco>
"""


def apart(on, integrator, step, nudge=1e-8, steps=400):
    """How many times as far apart as at the start two runs are at most, by MuJoCo's steps alone."""
    model = on.model.as_stepped()
    model.opt.timestep, model.opt.integrator = step, integrator_number(integrator)
    first, second = mujoco.MjData(model), mujoco.MjData(model)
    second.qpos[:] += nudge
    most = 0.0
    for k in range(steps):
        period = min(int(k * step / on.script.period), len(on.script.controls) - 1)
        for data in (first, second):
            data.ctrl[:] = on.script.controls[period]
            mujoco.mj_step(model, data)
        most = max(most, np.abs(first.qpos - second.qpos).max() / nudge)
    return most


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("integrator", ["implicit", "implicitfast"])
def test_a_limit_above_which_runs_hold_is_not_confirmed(integrator):
    on = course(LINKS, 1.0, "sines")
    limit = limit_of_method(on, integrator)
    assert limit.largest_step < 1.1 * 13.4e-3
    assert not limit.confirmed
    assert limit.holds_to > 1.5 * limit.largest_step
    for times in (1.1, 1.3, 1.5):
        assert apart(on, integrator, times * limit.largest_step) < LOST_GROWTH


def test_where_smaller_steps_diverge_the_limit_is_below_them(monkeypatch):
    """Some between them and the limit hold: an island, not a limit."""
    on = course(arm())
    velocity = AuditedMotion.last_velocity
    limit = limit_of_method(on, "euler")
    assert check_below(on, limit) == limit
    monkeypatch.setattr(
        AuditedMotion,
        "last_velocity",
        lambda self, of, step, t=None: (
            np.inf if 3e-3 < step < 3.4e-3 else velocity(self, of, step, t)
        ),
    )
    lower = check_below(on, limit)
    assert lower.confirmed
    assert 2.4e-3 < lower.largest_step < 3e-3


def test_a_ball_that_does_not_come_to_rest_chatters():
    on = course(DROP)
    limit = check_below(on, limit_of_method(on, "rk4"))
    assert 4.0e-3 < limit.chatters < 4.6e-3
    assert limit.reach == math.inf


@pytest.mark.long
def test_a_remedy_that_is_followed_gives_what_it_claims():
    on = course(arm())
    found = largest_steps(on.model, on.script, on.states, Allowance())
    (remedy,) = found.remedies
    assert remedy.change.name == "armature 0.02"
    assert remedy.limit.largest_step == pytest.approx(
        math.sqrt(2.0) * found.own.largest_step, rel=WITHIN
    )
    again = course(arm(armature=0.02))
    assert limit_of_method(again, "euler").largest_step == pytest.approx(
        remedy.limit.largest_step, rel=WITHIN
    )
    fine = [
        c.model.stepped(on.script, "rk4", 160).states
        for c in (on, replace(again, states=on.states))
    ]
    apart = np.linalg.norm(on.model.corners(fine[0]) - on.model.corners(fine[1]), axis=2)
    assert remedy.moved == pytest.approx(apart.max(), rel=0.01)


@pytest.mark.long
def test_an_unstable_step_is_said_first(tmp_path, capsys):
    file = tmp_path / "arm.xml"
    file.write_text(arm(step=0.005), "utf-8")
    command = ["audit", str(file), "--keyframe", "0", "--duration", "0.2", "--budget", "4"]
    assert main([*command, "--verbose"]) == 0
    second = capsys.readouterr().out.splitlines()[1]
    assert second.split(maxsplit=1)[0] == "stable"
    assert "no: 5 ms is too large; stable up to 4.4" in second
    assert DRIVEN in second
    assert main([*command, "--stable", "--json"]) == 1
    printed = capsys.readouterr()
    assert "is unstable; steps up to 0.0044" in printed.err
    data = json.loads(printed.out)
    assert data["unstable"]
    assert [set(s) for s in data["stability"]] == 4 * [
        {
            "integrator",
            "largest_step",
            "first",
            "confirmed",
            "why",
            "predicted",
            "chatters",
            "holds_to",
        }
    ]
    file.write_text(arm(step=0.004), "utf-8")
    assert main([*command, "--stable"]) == 0
    capsys.readouterr()
    assert main(["audit", str(file), "--contacts", "--stable"]) == 2
