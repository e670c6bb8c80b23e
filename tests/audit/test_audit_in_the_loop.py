"""Audits in the loop: each run asks the policy with its own states, the certified motion too."""

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plumbob import audit
from plumbob.engines import closed_loop
from plumbob.engines.closed_loop import NamedPolicy
from plumbob.reports.cli import main
from plumbob.tests.audit import looped_policies as policies

CART = """<mujoco><option timestep="0.01"/><worldbody>
<body><joint type="slide" axis="1 0 0"/><geom type="box" size=".1 .05 .05" mass="1"/>
<body><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 1" size=".02" mass=".1"/>
</body></body></worldbody><actuator><motor joint="rail"/></actuator>
<keyframe><key qpos="0 0.2"/></keyframe></mujoco>""".replace(
    'type="slide"', 'name="rail" type="slide"'
)
PENDULUM = """<mujoco><option timestep="0.01"/><worldbody><body><joint name="hinge" axis="0 1 0"/>
<geom type="sphere" pos="0 0 -.5" size=".1" mass="1"/></body></worldbody>
<actuator><motor joint="hinge"/></actuator><keyframe><key qpos="0.1"/></keyframe></mujoco>"""
HERE = Path(policies.__file__).parent
HELD = 0.02  # [s]
LINE = ["audit", "cart.xml", "--keyframe", "0", "--ctrl-period", str(HELD), "--in-the-loop"]


def looped(policy, text=CART, duration=0.5, **options):
    model = mujoco.MjModel.from_xml_string(text)
    return audit(
        model,
        keyframe=0,
        policy=policy,
        in_the_loop=True,
        period=HELD,
        duration=duration,
        **{"budget": 4.0, **options},
    )


def stepped(text, policy, finer, integrator, duration):
    """The end of a run in the loop with MuJoCo alone, at the file's step over `finer`."""
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.integrator = integrator
    model.opt.timestep /= finer
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    for period in range(round(duration / HELD)):
        data.ctrl[:] = policy(period * HELD, data.qpos, data.qvel)
        mujoco.mj_step(model, data, round(HELD / model.opt.timestep))
    return np.concatenate([data.qpos, data.qvel])


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    ("text", "policy", "duration"),
    [(CART, policies.balance, 0.5), (PENDULUM, policies.swing_up, 1.5)],
    ids=["cart-pole", "swing-up"],
)
def test_steps_256_times_smaller_confirm_the_certificate(text, policy, duration):
    found = looped(policy, text, duration)
    assert found.until == pytest.approx(duration)
    end = found.reference.states[-1]
    kinds = mujoco.mjtIntegrator
    # The certificate is of a corner; a coordinate or a rate in ten rad/s moves by ten times that.
    # RK4 itself is wrong by less than rounding there.
    accurate = stepped(text, policy, 256, kinds.mjINT_RK4, duration)
    assert np.abs(accurate - end).max() < 10.0 * found.uncertainty + 1e-11
    own, fine = (stepped(text, policy, n, kinds.mjINT_EULER, duration) - end for n in (1, 256))
    np.testing.assert_array_equal(own + end, found.states[1][-1])
    # first order: the second-order term of the own step is some percent of its error
    assert np.abs(own).max() / np.abs(fine).max() == pytest.approx(256.0, rel=0.2)


def test_replayed_controls_are_those_of_the_certified_motion():
    """The replay has them from the certified motion, and its error is another than the loop's."""
    found = looped(policies.balance)
    states = found.reference.states
    for period, control in enumerate(found.script.controls):
        nq = 2
        asked = policies.balance(period * HELD, states[period][:nq], states[period][nq:])
        np.testing.assert_array_equal(control, asked)
    replayed = iter(found.script.controls)
    end = stepped(CART, lambda *state: next(replayed), 1, mujoco.mjtIntegrator.mjINT_EULER, 0.5)
    own = stepped(CART, policies.balance, 1, mujoco.mjtIntegrator.mjINT_EULER, 0.5)
    ratio = np.abs(own - states[-1])[1] / np.abs(end - states[-1])[1]
    assert ratio != pytest.approx(1.0, rel=0.1)
    assert found.feedback_factor == pytest.approx(found.error / found.replayed_error)
    assert found.replayed.errors[-1] == found.replayed_error
    # Without feedback both are the same run.
    blind = looped(policies.rocks)
    assert blind.replayed_error == blind.error
    assert blind.feedback_factor == 1.0


@pytest.mark.long
def test_a_policy_with_a_memory_is_made_anew_for_each_run():
    """One object whose sum went on from run to run would not tend to the certified motion."""
    found = looped(policies.Integrates)
    assert found.until == pytest.approx(0.5)
    assert found.found.order.slope == pytest.approx(1.0, abs=0.1)
    same = looped(policies.Integrates())  # an object is reset
    assert same.error == found.error


def test_a_discontinuous_policy_ends_the_certificate():
    found = looped(policies.jumps, duration=0.3)
    assert found.until < 0.3
    assert found.reference.why.startswith("the policy is discontinuous: in control period")


HOSTILE = {
    "raises": "(KeyError: 'nothing')",
    "not_a_number": "returns [nan] at 0 s",
    "two_numbers": "not [1.0, 2.0]",
    "sleeps": "answers to a run take at most 0.2 s",
    "leaves": "(SystemExit: 0)",
    "keeps_state": "asked again at 0 s, it answers otherwise",
    "NeedsArguments": "a class without arguments",
    "not_callable": "MODULE:FUNCTION",
}


@pytest.mark.long(keep=3)
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_policies_are_one_line(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(closed_loop, "LONGEST_ANSWERS", 0.2)
    (tmp_path / "cart.xml").write_text(CART)
    policy = f"plumbob.tests.audit.looped_policies:{name}"
    line = [*LINE, "--duration", "0.1", "--budget", "1", "--policy", policy]
    assert main(line) == 2
    err = capsys.readouterr().err
    assert (err.count("\n"), "policy = " in err) == (1, True)
    assert HOSTILE[name] in err


def test_a_number_that_is_lost_later_ends_that_run():
    policies.KEPT.clear()
    found = looped(policies.later_not_a_number, duration=0.2)
    assert found.until == pytest.approx(0.06)
    assert "returns [nan] at 0.06 s" in found.reference.why


def test_on_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cart.xml").write_text(CART)
    policy = ["--policy", "plumbob.tests.audit.looped_policies:balance"]
    short = ["--duration", "0.2", "--budget", "2"]
    assert main([*LINE, *policy, *short]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "control (policy, in the loop of each run) held 20 ms" in lines[0]
    assert any(line.startswith("in the loop  feedback ") for line in lines)
    assert main([*LINE, *policy, *short, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["feedback_factor"] == pytest.approx(
        answer["error"] / answer["replayed_error"]
    )
    assert main([*LINE, *short]) == 2
    assert "in the loop = True: must be given with --policy" in capsys.readouterr().err


@pytest.mark.long
def test_other_engines_ask_the_policy_too(tmp_path):
    """DART's and PyBullet's steps are semi-implicit Euler's: in the loop their errors are about
    MuJoCo's in the loop, which feedback makes another than the replayed one."""
    for package in ("dartpy", "pybullet"):
        pytest.importorskip(package)
    file = tmp_path / "cart.xml"
    file.write_text(CART)
    policy = NamedPolicy("looped_policies:balance", str(HERE))
    found = audit(
        str(file),
        keyframe=0,
        policy=policy,
        in_the_loop=True,
        period=HELD,
        duration=0.5,
        budget=4.0,
        engines=("dart", "pybullet"),
        jobs=2,
    )
    assert abs(found.feedback_factor - 1.0) > 0.1
    assert len(found.engines) == 2
    for row in found.engines:
        assert row.built == pytest.approx(found.error, rel=0.05), row
