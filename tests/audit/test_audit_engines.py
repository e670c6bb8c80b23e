"""Other engines beside MuJoCo in an audit: MuJoCo with a change plays one, whose first differing
term is known."""

import json

import mujoco
import numpy as np
import pytest

from plumbob.engines.audit.engines import file_error
from plumbob.engines.study.model_reading import EVERY_FIELD_TEXT
from plumbob.engines.workers import Lost, Workers
from plumbob.reports.cli import main
from plumbob.tests.support.engines_beside import changed, held

SERVO = '<position name="servo" joint="hinge" kp="0.8" kv="0.09"/>'


@pytest.fixture(scope="module")
def motion(tmp_path_factory):
    """Of a model that has every field, under a control, without its floor and friction loss."""
    file = tmp_path_factory.mktemp("model") / "my.xml"
    text = EVERY_FIELD_TEXT.replace('frictionloss="0.05"', "").replace(SERVO, "")
    file.write_text(text.replace('name="bob" type', 'name="bob" contype="0" type'), "utf-8")
    return held(file, control="sines", duration=0.09)


def _sets(name, factor):
    def change(model):
        of = model.opt if hasattr(model.opt, name) else model
        getattr(of, name)[:] *= factor

    return change


@pytest.mark.parametrize(
    ("field", "factor", "term", "cause"),
    [
        ("dof_armature", 0.0, "mass matrix", "armature hinge: 0 for 0.21"),
        ("body_inertia", 1.001, "mass matrix", "inertia arm: 0.1101 0.1201 0.1301 for 0.11"),
        ("body_ipos", 1.001, "mass matrix", "of like bodies: joints or frames are not alike"),
        ("gravity", 0.999, "gravity", "gravity 0.2997 -0.3996 -1.618 for 0.3 -0.4 -1.62"),
        ("jnt_stiffness", 0.0, "passive", "stiffness hinge: 0 for 0.4"),
        ("dof_damping", 1.001, "passive", "damping hinge: 0.3103 for 0.31"),
        ("actuator_gear", 1 / 7, "actuator", "gear motor: 1 for 7"),
        ("actuator_gainprm", 0.0, "actuator", "all of it dropped"),
    ],
)
def test_a_change_is_the_first_term_and_its_force_puts_it_right(
    motion, field, factor, term, cause
):
    """Put right, what is left is the step's own error, to rounding."""
    result = file_error(changed(_sets(field, factor)), motion)
    assert result.first.term == term
    assert result.first.cause.startswith(cause)
    assert result.all_right == pytest.approx(result.step_error, rel=1e-6)
    assert result.part_explained is not None
    assert (
        result.error > 1.0001 * result.step_error or result.error < 0.9999 * result.step_error
    )


def test_rounding_to_single_precision_is_predicted(motion):
    result = file_error(changed(single=True, precision=2.0**-24), motion)
    assert [difference.term for difference in result.differences] == ["single precision"]
    assert result.apart == result.rounding
    assert 0.0 < result.rounding < 30 * 2.0**-24  # its steps
    assert (result.part_explained, result.reason) == (None, "no force undoes rounding")
    assert np.isnan(file_error(changed(), motion).rounding)


BALL = """<mujoco><worldbody><geom type="plane" size="1 1 1"/><body name="ball" pos="0 0 0.11">
<freejoint/><geom name="ball" size="0.1" {}/></body></worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("field", "term", "cause"),
    [
        ("geom_contype", "contact set", "missing: ball"),
        ("geom_solref", "acceleration", "contacts"),
    ],
)
def test_contacts_that_are_missing_or_others_are_not_put_right(tmp_path, field, term, cause):
    (file := tmp_path / "ball.xml").write_text(BALL.format(""), "utf-8")
    result = file_error(changed(_sets(field, 0)), held(file, duration=0.08))
    assert (result.first.term, result.first.cause) == (term, cause)
    assert result.part_explained is None
    assert "solver's" in result.reason


DAMPED = """<mujoco><option timestep="0.01"/><worldbody><body><joint name="hinge" axis="0 0 1"/>
<inertial pos="0.1 0 0" mass="1" diaginertia="0.1 0.1 0.1"/></body></worldbody><actuator>
<velocity joint="hinge" kv="4"/></actuator><keyframe><key qvel="1"/></keyframe></mujoco>"""


def test_another_integrator_is_not_called_constraints(tmp_path):
    """Under a servo's damping alone the acceleration in a step of Euler is -kv v / M, and in one of
    implicitfast -kv v / (M + h kv)."""
    (file := tmp_path / "damped.xml").write_text(DAMPED, "utf-8")

    def implicit(model):
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST

    result = file_error(changed(implicit), held(file, 0, duration=0.1))
    assert [difference.term for difference in result.differences] == ["integrator"]
    expected = 1.0 - 1.0 / (1.0 + 0.01 * 4.0 / 0.11)
    assert result.first.size == pytest.approx(expected, rel=1e-9)  # its own steps, to rounding
    assert result.first.cause.startswith("it steps implicitfast, the file euler: 0.27 of")
    assert result.reason == "no force stands for another integrator"
    assert result.error == pytest.approx(result.step_error)


def test_engines_in_the_command(motion, tmp_path, capsys, monkeypatch):
    """One without a reader of files, or whose process dies, costs a line with the reason."""
    command = ["audit", str(motion.file), "--duration", "0.02", "--budget", "2"]
    assert main([*command, "--engines", "ode,mujoco", "--json", "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    rows = json.loads(out)["engines"]
    assert [row["engine"] for row in rows] == ["ode", "mujoco"]
    for row in rows:
        assert row["why"] == "plumbob has no reader of model files for it"
        assert (row["error"], row["first_term"], row["part_explained"]) == (None, None, None)
    page = (tmp_path / "audit-my.html").read_text("utf-8")
    assert "Other engines on this file" in page
    monkeypatch.setattr(Workers, "results", lambda _, tasks, begun: [(tasks[0], Lost("died"))])
    main([*command, "--engines", "ode"])
    assert "\node " in capsys.readouterr().out
