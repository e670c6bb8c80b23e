"""What an audit says when its time runs out: all that was certified by then, and its own step."""

import time
from contextlib import redirect_stdout
from itertools import count

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.field import ContinuousField
from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.adapters.mujoco.own_model.user_stepper import UserStepper
from plumbob.engines.audit import reference as reference_module
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.audit import audited
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import certified
from plumbob.engines.audit.step_errors import errors_at_halved_steps
from plumbob.engines.own_motion import NotCertifiable, Start
from plumbob.engines.step_jacobian import step_jacobian
from plumbob.engines.tangent_space import TangentSpace
from plumbob.reports.audit_from_python import audit
from plumbob.reports.cli import main
from plumbob.tests.audit.scenes_as_models import PENDULUM, ball, compiled, pendulum

SECOND = 15_000  # readings of a clock, one at each evaluation


@pytest.fixture
def clock(monkeypatch):
    """Processor time that goes on by the same at each reading: what runs out does so at the same
    place."""
    readings = count()
    monkeypatch.setattr(time, "process_time", lambda: next(readings) / SECOND)


@pytest.mark.usefixtures("clock")
@pytest.mark.parametrize(("budget", "least"), [(0.1, 0.06), (0.2, 0.1)])
def test_what_is_certified_when_time_runs_out_is_kept(budget, least, monkeypatch):
    """A ball bounces, its contacts taken for chatter: layers end where their time does."""
    monkeypatch.setattr(reference_module, "CHATTER", 0)
    own = own_model(ball(0.13), "ball")
    found = certified(own, script(own, duration=0.4), Allowance(budget))
    assert least <= found.until < 0.4
    assert np.isfinite(found.uncertainty[: round(found.until / 0.02) + 1]).all()
    assert "the time given for it ended" in found.why


@pytest.mark.usefixtures("clock")
@pytest.mark.parametrize(
    ("allowed", "least", "most"),
    [
        (0.05, 0, 10),  # a twentieth of what all differences take: given up after the first one
        (0.5, 450, 550),  # half of it: they go on, as later ones may be faster
        (2.0, 950, 1100),
    ],
)
def test_a_jacobian_that_is_beyond_its_time_is_given_up_at_once(allowed, least, most):
    """Of 500 differences each takes two steps, before which the clock is read."""
    masses = "<body><joint type='slide'/><geom size='.1'/></body>" * 250
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{masses}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    begin = time.process_time()
    ends = begin + 1000 * allowed / SECOND
    stepper = UserStepper(model, data, data, "euler", 1e-3)
    about = (TangentSpace((1,) * 250), np.zeros(500), np.zeros(0), 1e-6)
    if allowed > 1.0:
        assert step_jacobian(stepper, *about, ends=ends).shape == (500, 500)
    else:
        with pytest.raises(NotCertifiable):
            step_jacobian(stepper, *about, ends=ends)
    assert least <= SECOND * (time.process_time() - begin) <= most


def test_a_model_whose_evaluations_are_refused_has_no_reference(monkeypatch):
    """The first one, which tells how long an evaluation takes, is refused too."""

    def refused(*_):
        raise NotCertifiable("no solution")

    monkeypatch.setattr(ContinuousField, "__call__", refused)
    found = audit(compiled(PENDULUM.format(integrator="Euler")), duration=0.1, budget=1.0)
    assert found.until == 0.0
    assert found.reference.why.startswith("no solution")


@pytest.mark.parametrize("asked", [[], ["--json"]])
def test_the_first_line_is_written_before_anything_is_computed(asked, tmp_path, monkeypatch):
    """Standard output is a file, which is written in blocks unless it is flushed."""
    model = tmp_path / "rod.xml"
    out = tmp_path / "out.txt"
    model.write_text(PENDULUM.format(integrator="Euler"))
    before = []

    def interrupted(*given):
        before.append(out.read_text("utf-8").split(maxsplit=1)[:1])
        raise KeyboardInterrupt

    monkeypatch.setattr("plumbob.engines.audit.kept_reference.certified", interrupted)
    with out.open("w", encoding="utf-8") as file, redirect_stdout(file):
        main(["audit", str(model), *asked])
    assert before == [[] if asked else ["rod.xml"]]


def test_the_own_step_is_run_whatever_the_time(request):
    own = own_model(pendulum(), "rod")
    motion = script(own, duration=0.2)
    known = certified(own, motion, Allowance(20.0))
    request.getfixturevalue("clock")
    steps = errors_at_halved_steps(own, motion, known, own.integrators, 0.0)
    assert [(s.integrator, s.parts) for s in steps] == [("euler", 1), ("euler", 2)]
    found = audited(own, motion, "rest", Allowance(1e-9))
    assert found.found is None
    assert "the time given for it ended" in found.reference.why


def test_a_candidate_that_diverges_is_dropped_at_once():
    """RK4 on stiff joints: steps from numbers that are none would take a hundred times as long."""
    joints = '<joint axis="0 1 0" stiffness="1e7"/><joint type="slide" stiffness="1e7"/>'
    rods = "".join(
        f'<body pos="{x} 0 .3">{joints}<geom type="capsule" size=".05 .2"/></body>'
        for x in range(8)
    )
    text = f"""<mujoco><option timestep=".001" integrator="RK4"/><worldbody>
      <geom type="plane" size="5 5 1"/>{rods}</worldbody>
      <keyframe><key qvel="{"1 1 " * 8}"/></keyframe></mujoco>"""
    own = own_model(compiled(text), "rods", Start(0))
    motion = script(own, duration=0.2)
    gone, holds = (own.stepped(motion, "rk4", parts) for parts in (80, 640))
    assert gone.why == "diverged within 0.02 s"
    assert holds.why == ""
    assert gone.seconds < 0.3 * holds.seconds  # an eighth of its steps in one of ten periods
