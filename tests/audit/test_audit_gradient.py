"""Derivatives of a model's end: those of the continuous motion against closed forms and other
computations, and the model's own ways against each other."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit import gradient as gradient_module
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.gradient import CertifiedGradient, certified_gradient
from plumbob.engines.audit.reference import certified
from plumbob.engines.derivative_ways import RunDerivatives
from plumbob.engines.own_motion import NotCertifiable
from plumbob.reports.cli import main
from plumbob.tests.audit.scenes_as_models import PENDULUM, compiled, pendulum

MASS, STIFFNESS, DURATION, STEP = 2.0, 50.0, 0.4, 0.01
OSCILLATOR = f"""
<mujoco>
  <option timestep="{STEP}" gravity="0 0 0" integrator="{{integrator}}"/>
  <worldbody><body><joint name="along" type="slide" stiffness="{STIFFNESS}"/>
    <geom size=".1" mass="{MASS}"/></body></worldbody>
  <actuator><motor name="push" joint="along" {{limits}}/></actuator>
</mujoco>
"""


def found_of(model, control="zero", duration=DURATION):
    """The derivatives of a compiled model, in more time than they take."""
    own = own_model(model, "model")
    motion = script(own, control, duration)
    reference = certified(own, motion, Allowance(60.0))
    return certified_gradient(own, motion, reference, len(motion.controls), Allowance(600.0))


def oscillator(integrator="Euler", limits=""):
    return compiled(OSCILLATOR.format(integrator=integrator, limits=limits))


def at_end(found, name):
    """Of the way of a name, shape (coordinates, numbers)."""
    computed = next(way.computed for way in found.ways if way.name == name)
    return np.asarray(computed[-1])


def test_of_an_oscillator_all_are_those_of_the_closed_forms():
    """Of the motion x'' = (u - k x)/m and of Euler's steps v += h (u - k x)/m, x += h v."""
    found = found_of(oscillator())
    frequency = math.sqrt(STIFFNESS / MASS)
    phase = frequency * found.times
    exact = [np.cos(phase), np.sin(phase) / frequency, (1.0 - np.cos(phase)) / STIFFNESS]
    assert found.by == ("position along", "velocity along", "control push")
    off = np.abs(found.exact[:, 0] - np.transpose(exact))
    assert (off <= 2.0 * found.uncertainty + 1e-12).all()
    assert found.certificate[-1] < 1e-7
    steps = round(DURATION / STEP)
    along = np.eye(2, 3)
    one = np.array([[1 - STEP**2 * STIFFNESS / MASS, STEP], [-STEP * STIFFNESS / MASS, 1.0]])
    for _ in range(steps):
        along = one @ along
        along[:, 2] += np.array([STEP**2, STEP]) / MASS
    for name, within in (("transition", 1e-8), ("central", 1e-10), ("forward", 1e-10)):
        assert at_end(found, name)[0] == pytest.approx(along[0], abs=within)
    assert found.horizon is None


@pytest.mark.parametrize("integrator", ["Euler", "RK4"])
def test_a_pendulum_is_confirmed_by_small_steps_and_another_eps(integrator):
    own = own_model(pendulum(integrator), "rod")
    motion = script(own, "sines", 0.5)
    reference = certified(own, motion, Allowance(60.0))
    found = certified_gradient(own, motion, reference, len(motion.controls), Allowance(600.0))
    for number in range(3):
        runs = [
            own.stepped(
                gradient_module._shifted_script(own, motion, number, by), "rk4", 64
            ).states
            for by in (1e-5, -1e-5)
        ]
        slope = own.coordinates(*runs)[-1] / 2e-5
        assert found.exact[-1, :, number] == pytest.approx(slope, abs=1e-9)
    transition = found.ways[0]
    if integrator == "RK4":
        assert transition.why == "mjd_transitionFD refuses RK4"
        assert found.along is found.ways[1]
    else:
        assert found.errors(transition)[-1] == pytest.approx(
            found.errors(found.ways[1])[-1], rel=1e-5
        )
        assert 1.0 / 30.0 < found.predicted_eps / (found.ways[1].eps or 0.0) < 30.0


@pytest.mark.parametrize(
    ("errors", "doubt", "horizon", "lost", "said"),
    [
        ([0, 0.2, 0.3, 0.1, 0.4], 0.0, None, (), "at most 40 % up to 0.4 s"),
        ([0, 0.2, 2.0, 3.0, 5.0], 0.0, 0.2, ((0.2, 0.4),), ""),
        (
            [0, 2.0, 3.0, 0.1, 1e-3],
            0.0,
            None,
            ((0.1, 0.2),),
            "from 0.1 to 0.2 s only; it is 0.1 %",
        ),
        ([0, 2.0, 0.1, 1.0, 2.0], 0.0, 0.3, ((0.1, 0.1), (0.3, 0.4)), ""),
        # the gradient is not known well enough at the end
        ([0, 0.2, 2.0, 3.0, 0.1], 0.5, 0.2, ((0.2, 0.3),), ""),
    ],
)
def test_a_horizon_is_a_time_from_which_on_the_error_stays_as_large(
    errors, doubt, horizon, lost, said
):
    """Of a gradient of 1, at five times."""
    exact = np.ones((5, 1, 1))
    way = RunDerivatives("central", exact + np.reshape(errors, (5, 1, 1)))
    uncertainty = np.array([[0.0]] * 4 + [[doubt]])
    times = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    found = CertifiedGradient(("x",), ("v",), exact, uncertainty, times, (way,), 1e-3)
    assert found.horizon == horizon
    assert found.lost == lost
    assert said in found.why


def test_what_has_no_derivative_is_left_out_with_its_reason():
    limited = 'ctrllimited="true" ctrlrange="0 1"'
    found = found_of(oscillator(limits=limited))
    assert found.left_out == ("control push: at an end of its range",)
    assert found.known.tolist() == [True, True, False]
    own = own_model(oscillator(), "model")
    motion = script(own, "zero", DURATION)
    reference = certified(own, motion, Allowance(60.0))
    with pytest.raises(NotCertifiable, match="layers"):
        certified_gradient(
            own, motion, replace(reference, widths=(1e-5, 1e-6)), 3, Allowance(600.0)
        )
    with pytest.raises(NotCertifiable, match="no reference"):
        certified_gradient(own, motion, reference, 0, Allowance(600.0))
    with pytest.raises(NotCertifiable, match="the time given for it ended"):
        certified_gradient(own, motion, reference, 3, Allowance(-1.0))


@pytest.mark.long
def test_command_tells_gradients_as_text_json_and_page(tmp_path, capsys):
    model = tmp_path / "rod.xml"
    model.write_text(PENDULUM.format(integrator="Euler"), "utf-8")
    asked = ["audit", str(model), "--ctrl", "sines", "--duration", "0.2", "--gradient"]
    assert main([*asked, "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "\ngradient " in printed
    assert "\nits horizon " in printed
    page = (tmp_path / "audit-rod.html").read_text("utf-8")
    assert "Derivatives of the pose at the end" in page
    assert "--gradient" in page
    assert main([*asked, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    keys = {"of", "by", "way", "exact", "uncertainty", "computed", "relative_error", "eps"}
    assert all(set(entry) == keys for entry in data["gradient"])
    assert {entry["way"] for entry in data["gradient"]} == {"transition", "central", "forward"}
    assert data["gradient_horizon"] is None
    assert data["gradient_lost"] == []
    assert data["gradient_why"].startswith("the error is at most")
    assert main(["audit", str(model), "--contacts", "--gradient"]) == 2
    assert "gradient" in capsys.readouterr().err
