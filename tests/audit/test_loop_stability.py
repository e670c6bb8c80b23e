"""Stability in the loop about a fixed point: up to which hold, delay and gain?"""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from plumbob.engines.audit import loop_stability as searched
from plumbob.reports.cli import main
from plumbob.tests.audit import looped_policies as policies
from plumbob.tests.audit.test_audit_in_the_loop import CART

STEP, PARTS = 0.01, 4  # [s], steps a hold
INERTIA, DAMPING = 0.5, 0.3  # [kg m^2], [N m s/rad]
JOINT = f"""<mujoco><option timestep="{STEP}" gravity="0 0 0"/><worldbody><body>
<inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/>
<joint name="knee" axis="0 0 1" damping="{DAMPING}"/></body></worldbody>
<actuator><motor joint="knee"/></actuator></mujoco>"""
MODULE = "plumbob.tests.audit.looped_policies:"


def grows(hold, delay, gain, periods=4000):
    """Whether a nudged joint grows under MuJoCo's Euler, whose damping is implicit: a recursion in
    numbers, a step after the other."""
    x, v = 1.0, 0.0
    stiffness, rate_gain = gain * np.array(policies.GAINS_OF_JOINT)
    answers = [0.0] * delay
    held = 0.0
    largest = []
    for step in range(periods * hold):
        if step % hold == 0:
            held = -(stiffness * x + rate_gain * v)
            largest.append(abs(x) + abs(v))
            if not largest[-1] < 1e12:
                return True
        answers.append(held)
        v = (INERTIA * v + STEP * answers.pop(0)) / (INERTIA + STEP * DAMPING)
        x += STEP * v
    return max(largest[-periods // 4 :]) >= max(largest[: periods // 4])


def answer(capsys, tmp_path, text, policy, *words, code=0, methods=()):
    file = tmp_path / "own.xml"
    file.write_text(text)
    line = ["stability", str(file), *methods, "--policy", f"{MODULE}{policy}", "--json", *words]
    assert main(line) == code
    return json.loads(capsys.readouterr().out)["loops"]


def test_limits_are_those_of_a_recursion(capsys, tmp_path):
    """A hold of four steps whose answers come five steps late: a period and a quarter."""
    late = 5
    words = ["--ctrl-period", str(PARTS * STEP), "--delay", str(late * STEP)]
    (loop,) = answer(capsys, tmp_path, JOINT, "holds_joint", *words)
    hold, delay, gain = loop["intervals"]
    steps = round(hold["high"]["value"] / STEP)
    assert not grows(steps, round(late / PARTS * steps), 1.0)
    assert grows(steps + 1, round(late / PARTS * (steps + 1)), 1.0)
    steps = round(delay["high"]["value"] / STEP)
    assert (grows(PARTS, steps, 1.0), grows(PARTS, steps + 1, 1.0)) == (False, True)
    # the factor is bisected to a thousandth
    factor = gain["high"]["value"]
    assert (grows(PARTS, late, 0.998 * factor), grows(PARTS, late, 1.002 * factor)) == (
        False,
        True,
    )
    assert all(interval["high"]["confirmed"] for interval in loop["intervals"])
    assert {interval["high"]["place"] for interval in loop["intervals"]} == {"joint knee"}


@pytest.mark.long
def test_a_cart_pole_has_a_least_gain_and_a_longest_hold(capsys, tmp_path):
    words = ["--ctrl-period", "0.02", "--keyframe", "0"]
    methods = ["mujoco/euler", "mujoco/rk4"]
    moved = CART.replace('qpos="0 0.2"', 'qpos="0.1 0.05"')
    euler, rk4 = answer(capsys, tmp_path, moved, "balance", *words, methods=methods)
    np.testing.assert_allclose(euler["state"], 0.0, atol=1e-9)
    for loop in (euler, rk4):
        _, _, gain = loop["intervals"]
        assert gain["low"]["value"] < 1.0 < gain["high"]["value"]
        ends = [e for i in loop["intervals"] for e in (i["low"], i["high"]) if e]
        assert len(ends) == 4
        assert all(end["confirmed"] for end in ends)


@pytest.mark.long
def test_a_jacobian_of_the_policys_own_is_its_derivative(capsys, tmp_path):
    """One that is twice as large gives limits that runs do not confirm."""
    right, wrong = (
        answer(capsys, tmp_path, JOINT, name, "--ctrl-period", "0.04")[0]
        for name in ("KnowsItsJacobian", "ExaggeratesItsJacobian")
    )
    plain = answer(capsys, tmp_path, JOINT, "holds_joint", "--ctrl-period", "0.04")[0]
    assert (right["by_jacobian"], plain["by_jacobian"]) == (True, False)
    for known, differenced in zip(right["intervals"], plain["intervals"], strict=True):
        assert known["high"]["value"] == pytest.approx(differenced["high"]["value"], rel=1e-3)
    gain = wrong["intervals"][2]["high"]
    assert gain["value"] == pytest.approx(right["intervals"][2]["high"]["value"] / 2, rel=1e-2)
    assert (gain["confirmed"], gain["why"]) == (False, "runs 10 % outside do not grow")


def test_an_unstable_loop_and_none(capsys, tmp_path):
    (loop,) = answer(capsys, tmp_path, JOINT, "pushes_away", code=1)
    assert loop["multiplier"] > 1.0
    assert loop["intervals"] == []
    file = tmp_path / "own.xml"
    assert main(["stability", str(file), "--policy", f"{MODULE}pushes_always"]) == 3
    assert "no fixed point under the policy near the start" in capsys.readouterr().err


WRONG = {
    "Integrates": "one without a memory",
    "keeps_state": "one without a memory",
    "rocks_joint": "one that does not depend on time",
    "steps_at_zero": "one that is smooth at the fixed point",
    "raises": "(KeyError: 'nothing')",
    "not_a_number": "returns [nan] at 0 s",
    "pushes_beyond_mujoco": "returns [100000000000.0] at 0 s, beyond 1e+10",
    "two_numbers": "not [1.0, 2.0]",
    "leaves": "(SystemExit: 0)",
    "HasNoGoodJacobian": "one whose jacobian(time, qpos, qvel) returns finite numbers",
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_policies_are_one_line(name, capsys, tmp_path):
    file = tmp_path / "own.xml"
    file.write_text(CART if name == "Integrates" else JOINT)
    assert main(["stability", str(file), "--policy", f"{MODULE}{name}"]) == 2
    err = capsys.readouterr().err
    assert (err.count("\n"), "policy = " in err) == (1, True)
    assert WRONG[name] in err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--delay", "0.015"], "delay = 0.015: must be a multiple of the step"),
        (["--delay", "9"], " s, up to "),
        (["--delay", "1e308"], "delay = 1e+308: must be a multiple of the step"),
        (["--ctrl-period", "1e308"], "ctrl period = 1e+308: must be at most"),
        (["--ctrl", "sines"], "left out with --policy"),
        (["--duration", "2"], "left out with --policy"),
        (["pymunk/default"], "method"),
    ],
)
def test_wrong_options_are_one_line(words, message, capsys, tmp_path):
    file = tmp_path / "own.xml"
    file.write_text(JOINT)
    assert main(["stability", str(file), *words, "--policy", f"{MODULE}holds_joint"]) == 2
    err = capsys.readouterr().err
    assert (err.count("\n"), message in err) == (1, True)


def test_the_terminal_says_what_limits_each_end(capsys, tmp_path):
    file = tmp_path / "own.xml"
    file.write_text(JOINT)
    assert main(["stability", str(file), "--policy", f"{MODULE}holds_joint"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    assert lines[1].startswith("hold   stable up to ")
    assert "runs confirm; beyond, joint knee" in lines[1]
    for of in ("servo/held-half", str(file)):
        assert main(["stability", of, "--delay", "1"]) == 2


def test_runs_that_take_too_long_confirm_nothing(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(searched, "MOST_NUDGED_STEPS", 10)
    (loop,) = answer(capsys, tmp_path, JOINT, "holds_joint")
    assert not any(interval["high"]["confirmed"] for interval in loop["intervals"])
    assert math.isfinite(loop["intervals"][0]["high"]["value"])
    assert Path(tmp_path / "own.xml").exists()
