"""The engine of engines/README.md, which is one file: its first lines say all that is needed to
install it, and it runs eight systems with the errors that theory predicts."""

import importlib.util
import tomllib
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.method import Unsupported
from plumbob.engines.registry import method as find_method
from plumbob.engines.stepper import State
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene
from plumbob.reports.cli import main
from plumbob.reports.judge.verdict import judge
from plumbob.tests.outside.installed_packages import PACKAGES, changed, install, seen
from plumbob.tests.peers.test_dart_mechanisms import ALL_JOINTS

FILE = PACKAGES / "tree_engine" / "tree_engine.py"
TEXT = FILE.read_text("utf-8")
# A scene of each system, the time that it runs [s], and a step [s] that theory covers.
SCENES = {
    "projectile/thrown": (1.5, 1e-2),
    "simple-pendulum/near-top-1e-6": (1.0, 5e-3),
    "linear-pendulum/overdamped": (1.0, 5e-3),
    "cone-pendulum/equal-wells-short": (0.5, 5e-3),
    "n-pendulum/triple": (0.5, 5e-3),
    "heavy-top/nutating": (0.5, 2e-3),
    "servo/motor-damped": (0.5, 5e-3),
    "free-body/symmetric": (1.0, 2e-3),
}


def installed(site, text=TEXT):
    """Install the file by the project that its own docstring shows."""
    shown = text.partition("pyproject.toml`:\n")[2].partition("\nAfter")[0]
    project = tomllib.loads(shown.replace("    ", ""))["project"]
    install(site, project["name"], project["entry-points"], tree_engine=text)
    return seen(site)


def verdict(name):
    """The verdict on a short run of a scene, and why."""
    duration, step = SCENES[name]
    case, method = case_of(scene(name)).lasting(duration), find_method("tree/euler")
    found, _ = measure(case, method, step)
    judged = judge(found, case.system, method)
    return judged.verdict, judged.reason


def module():
    """The file as a module."""
    spec = importlib.util.spec_from_file_location("tree_engine", FILE)
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def test_the_readme_shows_its_parts():
    readme = (Path(__file__).parents[2] / "engines" / "README.md").read_text("utf-8")
    blocks = readme.partition("## Your own engine")[2].partition("## Limits")[0].split("```")
    (points, python) = blocks[1:4:2]
    assert python.removeprefix("python\n") in TEXT
    assert points.removeprefix("toml\n") in FILE.with_name("pyproject.toml").read_text("utf-8")
    assert len(TEXT.splitlines()) <= 150
    assert set(module().SCENES.split()) == set(SCENES)


@pytest.mark.parametrize("name", SCENES)
def test_each_of_eight_systems_has_the_error_that_theory_predicts(name, tmp_path):
    with installed(tmp_path):
        assert verdict(name) == ("predicted", "")


@pytest.mark.long(keep=2)
@pytest.mark.parametrize(
    ("name", "right", "wrong"),
    [
        ("projectile/thrown", "* self.mechanism.gravity", "* 1.001 * self.mechanism.gravity"),
        ("heavy-top/nutating", "spin @ turning, flow", "0.0 * spin @ turning, flow"),
        ("free-body/symmetric", "- cross(spin) @ moments @ spin", ""),
        ("cone-pendulum/equal-wells-short", "free[rates] = False", "free[rates] = True"),
        ("servo/motor-damped", "motor.bias[1]", "1.001 * motor.bias[1]"),
    ],
)
def test_a_defect_is_off_its_prediction(name, right, wrong, tmp_path):
    with installed(tmp_path, changed(TEXT, right, wrong)):
        assert verdict(name)[0] in ("off-prediction", "diverged")


def test_every_joint_has_mujoco_s_acceleration():
    """Two trees with every kind of joint, springs, dampers, a weight that is carried, and motors
    with limits, in a random state."""
    model = mujoco.MjModel.from_xml_string(ALL_JOINTS)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    data = mujoco.MjData(model)
    rng = np.random.default_rng(1)
    mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
    data.qvel[:] = rng.normal(size=model.nv)
    data.ctrl[:] = 2.0 * rng.normal(size=model.nu)
    mujoco.mj_forward(model, data)
    made = module().Tree(compiled_mechanism(model), 1e-3)
    made.put(State(data.qpos.copy(), data.qvel.copy()))
    # A mass matrix of condition 1e2 magnifies the rounding of its numbers.
    found = made.accelerations(made.forces(data.ctrl))
    np.testing.assert_allclose(found, data.qacc, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize(
    ("rest", "why"),
    [
        ('<geom type="plane" size="1 1 1"/>', "Touch of shapes"),
        ('<body><joint name="stop" range="0 1"/><geom size="1"/></body>', "Joint stop"),
    ],
)
def test_what_it_cannot_do_is_refused_by_name(rest, why):
    ball = '<body pos="0 0 3"><freejoint/><geom size="1"/></body>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{ball}{rest}</worldbody></mujoco>"
    )
    tree_engine = module()
    with pytest.raises(Unsupported, match=why):
        tree_engine.Tree(compiled_mechanism(model), 1e-3)


@pytest.mark.long
def test_validate_expects_all_of_it(tmp_path, monkeypatch, capsys):
    """With worker processes, which find the file by themselves."""
    site = tmp_path / "site"
    with installed(site):
        monkeypatch.setenv("PYTHONPATH", str(site), prepend=":")
        monkeypatch.chdir(tmp_path)
        assert main(["validate", "--methods", "tree", "--jobs", "2"]) == 0
    assert "0 unexpected" in capsys.readouterr().out
