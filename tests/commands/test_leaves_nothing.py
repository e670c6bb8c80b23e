"""A command leaves what is asked for and nothing else, and says nothing on stderr."""

from pathlib import Path

import mujoco
import pytest

from plumbob import audit
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.workers import Workers
from plumbob.reports.cli import main

# A long body that turns fast, on a stiff spring: MuJoCo warns of steps beyond the largest.
UNSTABLE = """<mujoco><option timestep="0.01"/><worldbody><body><joint axis="0 0 1"/>
<joint type="slide" axis="1 0 0" stiffness="4e4"/>
<geom type="box" size=".3 .02 .01" pos=".2 0 0"/></body></worldbody>
<actuator><motor joint="spring"/></actuator></mujoco>""".replace(
    '"slide"', '"slide" name="spring"'
)
POLICY = """
import os
print("loaded")
def act(time, qpos, qvel):
    print("called")
    os.write(1, b"called by C")
    return [0.0]
"""
TURNS = ("--qvel", "30,1", "--duration", "0.1", "--budget", "0.5")
SMALL = ("linear-pendulum/overdamped", "mujoco/euler")
COMMANDS = {
    "audit": (("audit", "m.xml", *TURNS), set()),
    "audit, page": (
        ("audit", "m.xml", *TURNS, "--out", "out"),
        {"out/audit-m.html", "out/audit-m.json"},
    ),
    "contacts": (("audit", "m.xml", "--contacts"), set()),
    "list": (("list",), set()),
    "solve": (("solve", SMALL[0], "--times", "0.1"), set()),
    "run": (("run", *SMALL, "--step", "1e-2"), set()),
    "settings": (("settings", "mujoco/euler+coulomb", "--step", "1e-3"), set()),
    "check": (("settings", "--check", "m.xml"), set()),
    "cite": (("cite",), set()),
    "gradient": (("gradient", *SMALL, "--by", "theta", "--step", "1e-2"), set()),
    "stability": (
        ("stability", *SMALL, "--out", "."),
        {"stability.html", "stability.sqlite3"},
    ),
    "models": (("models",), set()),
}
# The first verdict of an audit, the page, and why contacts are not audited
LINES_ON_STDERR = {"audit": 1, "audit, page": 2, "contacts": 1}
LONG = ("audit, page", "gradient", "stability", "run")


@pytest.mark.parametrize(
    "kind", [pytest.param(k, marks=[pytest.mark.long] * (k in LONG)) for k in COMMANDS]
)
def test_a_command_leaves_what_is_asked_for(kind, tmp_path, monkeypatch, capfd):
    words, asked = COMMANDS[kind]
    monkeypatch.chdir(tmp_path)
    Path("m.xml").write_text(UNSTABLE)
    code = main(words)
    out, err = capfd.readouterr()
    assert code == (2 if kind == "contacts" else 0)  # it has no free body
    assert err.count("\n") == LINES_ON_STDERR.get(kind, 0)
    assert bool(out) == (kind != "contacts")
    left = {str(path) for path in Path().rglob("*") if path.is_file()}
    assert left == asked | {"m.xml"}


STEPS = ("mj_step", "mj_forward", "mj_forwardSkip", "mj_fwdPosition", "mj_inverse")


def test_no_call_of_an_audit_is_heard(monkeypatch):
    """Each call of the engine that may warn is made where what it says is collected."""
    heard = set()

    def watched(name, call):
        def called(model, *arguments, **named):
            if model.nv and mujoco.get_mju_user_warning() is None:  # an empty model cannot warn
                heard.add(name)
            return call(model, *arguments, **named)

        return called

    for name in STEPS:
        monkeypatch.setattr(mujoco, name, watched(name, getattr(mujoco, name)))
    model = mujoco.MjModel.from_xml_string(UNSTABLE)
    result = audit(model, qvel=[30.0, 1.0], duration=0.1, budget=0.5)
    assert heard == set()
    assert mujoco.get_mju_user_warning() is None
    mujoco.mj_forward(model, mujoco.MjData(model))
    assert heard == {"mj_forward"}
    assert result.error > 0.0


def test_what_an_audit_does_in_other_processes_is_not_heard_either():
    with Workers(1) as workers:
        collects = Allowance(executor=workers).start(mujoco.get_mju_user_warning)()
    assert collects is not None


def test_what_a_policy_prints_is_no_part_of_the_results(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    Path("m.xml").write_text(UNSTABLE)
    Path("talking_policy.py").write_text(POLICY)
    assert main(["audit", "m.xml", *TURNS, "--json", "--policy", "talking_policy:act"]) == 0
    out, err = capfd.readouterr()
    assert out.startswith("{\n")
    assert "called" not in out
    assert "loaded" not in out
    assert all(said in err for said in ("loaded\n", "called\n", "called by C"))
