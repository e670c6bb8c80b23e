"""Statements of the page on the simple pendulum hold."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbob.engines.registry import method as find_method
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.runner import run_study
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses import measurements
from plumbob.reports.analyses.simple_pendulum import (
    SECTION,
    bob,
    claims,
    notebook,
    orders,
)
from plumbob.reports.records.plain_data import FOR_TEMPLATES, plain
from plumbob.reports.view.finding_text import read_findings
from plumbob.tests.support.declared import finding, measured, nothing

ROOT = Path(__file__).parents[2]
SCENES = ("free-small", "free-large", "near-top-1e-6")


@cache
def study():
    """Three scenes with two methods whose errors the series reaches."""
    scenes = [find_scene(f"simple-pendulum/{name}") for name in SCENES]
    return run_study(
        scenes,
        find_methods("ode/rk4,ode/leapfrog"),
        "quick",
        timed=False,
        requests=SECTION.requests,
    )


@pytest.mark.long
def test_errors_of_the_notebook_are_those_that_physics_says():
    # the seven figures, measured with the notebook's integrator, to three digits
    wanted = [1.29e-4, 0.00777, 0.0418, 0.0597, 2.49e-5, 1.07e-4, 1.64e-4]
    cases = notebook.notebook_errors(study()).cases
    assert [float(f"{case.error:.3g}") for case in cases] == wanted
    assert [float(f"{case.predicted:.3g}") for case in cases] == wanted
    differences = notebook.linear_errors().differences
    for case in cases:  # as the summary states for the linear equation
        assert differences[case.label] > max(case.error, case.of_linear)


def _by_rk4(name, linear):
    """theta [rad] after each of a thousand steps of 0.05 s of RK4, written out, shape (1001,)."""
    posed = find_scene(f"{'linear' if linear else 'simple'}-pendulum/{name}").parameters
    start, rate, damping = (posed.get(n, 0.0) for n in ("theta", "theta_dot", "damping_rate"))

    def slope(x):
        pull = x[0] if linear else math.sin(x[0])
        return np.array([x[1], -damping * x[1] - 9.8 * pull])

    x = np.array([start, rate])
    h = 0.05
    angles = [start]
    for _ in range(1000):
        k1 = slope(x)
        k2 = slope(x + h / 2 * k1)
        k3 = slope(x + h / 2 * k2)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(x + h * k3))
        angles.append(float(x[0]))
    return np.array(angles)


@pytest.mark.long
@pytest.mark.parametrize(("label", "name"), notebook.CASES.items())
def test_errors_are_the_largest_of_all_steps(label, name):
    """And the README says them: a recording has every second step."""
    readme = (ROOT / "models/simple_pendulum/README.md").read_text("utf-8")
    (line,) = (
        line for line in readme.splitlines() if line.startswith(f"| {label} | `{name}` |")
    )
    times = np.linspace(0.0, 50.0, 1001)
    for linear, shown in zip((False, True), line.split("|")[3:5], strict=True):
        exact = measurements.case(
            f"{'linear' if linear else 'simple'}-pendulum/{name}"
        ).reference
        error = float(np.abs(_by_rk4(name, linear) - exact.observe(times)["theta"]).max())
        assert float(shown) == pytest.approx(error, rel=5e-3)  # half of its last digit
        kind = notebook.LINEAR_SCENES if linear else notebook.NONLINEAR_SCENES
        found, predicted = notebook.rk4_error(study(), kind + name)
        # the cubic between every second step leaves (2 h)^4/384 of a fourth derivative, the most in
        # case 3, where the error oscillates at twice the rate of its rotation: 1.2e-4 of it
        assert found == pytest.approx(error, rel=2e-4)
        assert predicted == pytest.approx(error, rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "rate", "turns"), [("slow", 200, 28.5536), ("fast", 500, 73.0428)]
)
def test_turns_are_counted_from_the_start(name, rate, turns):
    solved = solve_ivp(
        lambda t, x: [x[1], -9.8 * math.sin(x[0])],
        (0.0, 50.0),
        [math.radians(-120), math.radians(rate)],
        "DOP853",
        rtol=1e-12,
        atol=1e-12,
    )
    gone = (solved.y[0, -1] - solved.y[0, 0]) / math.tau
    assert gone == pytest.approx(turns, abs=5e-5)
    assert claims.rotation_numbers(f"rotating-{name}").turns == pytest.approx(gone, abs=1e-6)
    said = " ".join(one.ours for one in finding(claims.NOTEBOOK_CLAIMS, study()).statements)
    assert f"{turns:.2f} turns in 50 s" in said


@pytest.mark.long
def test_every_case_has_its_plots():
    motions = plain(notebook.cases(study()), FOR_TEMPLATES)
    galleries = read_findings(notebook.CASE_MOTIONS.template, motions)
    assert [gallery.title.split(":")[0] for gallery in galleries] == [
        f"Case {n} of the notebook" for n in range(1, 8)
    ]
    for gallery in galleries:
        for figure in gallery.figures:
            names = [trace["name"] for trace in figure.traces]
            assert names == ["non-linear, exact", "RK4", "linear, exact", "RK4"]
        assert gallery.figures[0].traces[0]["x"][-1] == 50.0
    # degrees: all the turns of case 4
    assert max(galleries[3].figures[0].traces[0]["y"]) > 360.0 * 50.0


@pytest.mark.long
def test_a_held_control_costs_orders():
    ran = measured(orders.FORCED_LARGE, orders.READ, 2e-2, 1e-2, 5e-3, 3e-3)
    found = orders.held_control(ran).by_method
    slopes = {name: of.order.slope for name, of in found.items() if of.order}
    predicted = {name: of.predicted.slope for name, of in found.items() if of.predicted}
    wanted = {
        "ode/rk4": 4.0,
        "mujoco/rk4": 1.0,
        "mujoco/rk4+midpoint": 2.0,
        "mujoco/euler": 1.0,
        "mujoco/euler+midpoint": 1.0,
    }
    assert slopes == pytest.approx(wanted, abs=0.1)  # higher terms at these steps
    assert slopes == pytest.approx(predicted, abs=2e-3)


@pytest.mark.long
def test_the_notebooks_statements():
    numbers = claims.numbers()
    found = finding(claims.NOTEBOOK_CLAIMS, nothing())
    assert len(found.tables[0].rows) == 15
    ours = {line[0].text: line[2].text for line in found.tables[0].rows}
    assert "solved exactly" in ours["equation of motion: mLθ̈ + CLθ̇ + mg sin θ = F(t)"]
    assert "11.5 % faster" in ours["case 3: the two are compared at 200°/s"]
    assert "30 %" in found.summary
    # theta_0^2/16 and the next term of the period's series, 11 theta_0^4/3072
    start = math.radians(10.0)
    series = start**2 / 16 + 11 * start**4 / 3072
    assert numbers.lengthening["1"] == pytest.approx(series, rel=1e-5)
    # the linear pendulum's amplitude; the start is forgotten as e^(-0.1 t)
    steady = 1.5 / math.hypot(9.8 - 2.8**2, 0.2 * 2.8)
    assert numbers.forced_linear == pytest.approx(steady, rel=0.02)
    assert numbers.forced > 1.5
    small = numbers.partings["1"]
    # the phases part by theta_0^2/16 of what has passed: amplitude * sin(omega t theta_0^2/16)
    by_phase = start * math.sin(math.sqrt(9.8) * 50.0 * start**2 / 16)
    assert small.largest == pytest.approx(by_phase, rel=0.02)
    assert small.relative == pytest.approx(0.295, abs=5e-3)
    # a small damped swing keeps to the exponential up to its amplitude squared, a large one not
    assert 5e-4 < numbers.decay["5"] < 1e-3
    assert 0.05 < numbers.decay["6"] < 0.2


@pytest.mark.long
def test_the_equation_is_that_of_mujoco_s_multibody_model():
    ran = replace(study(), convergence=())
    assert claims.smallest_error(ran) is None
    scene = find_scene("simple-pendulum/free-large")
    (how,) = find_methods(claims.CLAIMS_METHOD)
    found = convergence_study(scene, how, 10_000, (1e-2, 5e-3))
    finest = claims.smallest_error(replace(ran, convergence=(found,)))
    assert finest
    error, step = finest
    assert step == 5e-3
    assert error < 1e-6


@pytest.mark.long
def test_the_bob_in_the_plane():
    found = bob.numbers()
    distances = {case.label: case for case in found.distances}
    assert distances["1"].parted is distances["5"].parted is None
    assert distances["2"].largest == pytest.approx(2.0, rel=0.01)  # opposite ends of a diameter
    x, y = found.paths[0]
    assert x[0] == pytest.approx(-math.sin(math.radians(120)))
    assert y[0] == pytest.approx(0.5)
    # within three periods of 2.76 s, as the summary says
    assert bob.bob_distances("free-large")[:3320].max() > 1.9


def test_an_accelerometer_at_the_bob_reads_the_notebooks_acceleration_less_gravity():
    """Semi-implicit Euler's acceleration has the error of its angle, and that is seen."""

    def read(method):
        request = replace(bob.ACCELEROMETER, method=method)
        run = request.made(find_scene(request.scene), find_method(method))
        assert run
        return bob.accelerometer_readings(run)

    found = read(bob.ACCELEROMETER.method)
    coarse = read("mujoco/euler")
    assert found.gap < 1e-8  # the error of theta is 3e-10 rad, and (dθ/dt)² is up to 29.4 /s²
    # energy, from -120 deg to hanging
    assert found.along == pytest.approx(2 * 9.8 * 1.5, rel=1e-5)
    assert found.reads_across < 1e-12
    assert found.gap_of_pull < 1e-12
    assert coarse.gap > 1e-3
    assert read("ode/rk4") is None  # no sensor
