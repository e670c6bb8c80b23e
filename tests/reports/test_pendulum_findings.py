"""Statements of the page on the simple pendulum hold."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbob.analytic.reference import Array
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import run_study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses import measurements
from plumbob.reports.analyses.energy_drift import Drift
from plumbob.reports.analyses.simple_pendulum import (
    SECTION,
    bob,
    claims,
    energy,
    exactness,
    notebook,
    orders,
    tension,
)
from plumbob.reports.judge.expectations import as_expected, expected
from plumbob.reports.judge.verdict import Judgement
from plumbob.reports.view.content import Figure, Finding, Table
from plumbob.tests.support.declared import declared, made, nothing

ROOT = Path(__file__).parents[2]
SCENES = ("free-small", "free-large", "near-top-1e-6")


@cache
def study() -> Study:
    """Three scenes with two methods whose errors the series reaches."""
    scenes = [find_scene(f"simple-pendulum/{name}") for name in SCENES]
    return run_study(
        scenes,
        find_methods("ode/rk4,ode/leapfrog"),
        "quick",
        timed=False,
        requests=SECTION.requests,
    )


def texts(found: Finding, table: int = 0) -> list[list[str]]:
    """Rows of a finding's table as text."""
    return [[cell.text for cell in row] for row in found.tables[table].rows]


@pytest.mark.long
def test_errors_of_the_notebook_are_those_that_physics_says() -> None:
    # the seven figures, measured with the notebook's integrator, to three digits
    found = notebook.finding(study())
    wanted = ["1.29e-4", "0.00777", "0.0418", "0.0597", "2.49e-5", "1.07e-4", "1.64e-4"]
    rows = texts(found)
    assert [row[3] for row in rows] == wanted
    assert [row[4] for row in rows] == wanted  # predicted
    for row in rows:
        own, linear, apart = (float(row[i]) for i in (3, 5, 6))
        assert apart > max(own, linear)  # as the summary states for the linear equation


def _by_rk4(name: str, linear: bool) -> Array:
    """theta [rad] after each of a thousand steps of 0.05 s of RK4, written out, shape (1001,)."""
    posed = find_scene(f"{'linear' if linear else 'simple'}-pendulum/{name}").parameters
    start, rate, damping = (posed.get(n, 0.0) for n in ("theta", "theta_dot", "damping_rate"))

    def slope(x: Array) -> Array:
        pull = x[0] if linear else math.sin(x[0])
        return np.array([x[1], -damping * x[1] - 9.8 * pull])

    x, h, angles = np.array([start, rate]), 0.05, [start]
    for _ in range(1000):
        k1 = slope(x)
        k2 = slope(x + h / 2 * k1)
        k3 = slope(x + h / 2 * k2)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(x + h * k3))
        angles.append(float(x[0]))
    return np.array(angles)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(("label", "name"), [case[:2] for case in notebook.CASES])
def test_errors_are_the_largest_of_all_steps(label: str, name: str) -> None:
    """And the README says them: a recording has every second step."""
    readme = (ROOT / "models/simple_pendulum/README.md").read_text("utf-8")
    (line,) = (line for line in readme.splitlines() if line.startswith(f"| {label} | `{name}` |"))
    times = np.linspace(0.0, 50.0, 1001)
    for linear, shown in zip((False, True), line.split("|")[3:5], strict=True):
        exact = measurements.case(f"{'linear' if linear else 'simple'}-pendulum/{name}").reference
        error = float(np.abs(_by_rk4(name, linear) - exact.observe(times)["theta"]).max())
        assert float(shown) == pytest.approx(error, rel=5e-3)  # half of its last digit
        kind = notebook.LINEAR if linear else notebook.SIMPLE
        found, predicted = notebook._error(study(), kind + name)
        # the cubic between every second step leaves (2 h)^4/384 of a fourth derivative, the most in
        # case 3, where the error oscillates at twice the rate of its rotation: 1.2e-4 of it
        assert found == pytest.approx(error, rel=2e-4)
        assert predicted == pytest.approx(error, rel=1e-6)


def test_the_difference_of_runs_is_the_largest_of_all_steps() -> None:
    apart = float(np.abs(_by_rk4("damped-small", False) - _by_rk4("damped-small", True)).max())
    assert apart == pytest.approx(0.0050036, abs=5e-8)
    found = claims.parting(study(), "damped-small").in_runs
    assert found == pytest.approx(apart, rel=2e-4)  # the cubic between every second step


@pytest.mark.parametrize(
    ("name", "rate", "turns"), [("slow", 200, 28.5536), ("fast", 500, 73.0428)]
)
def test_turns_are_counted_from_the_start(name: str, rate: float, turns: float) -> None:
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
    assert claims.turns(f"rotating-{name}") == pytest.approx(gone, abs=1e-6)
    said = " ".join(one.ours for one in claims.finding(study()).statements)
    assert f"{turns:.2f} turns in 50 s" in said


@pytest.mark.long
def test_every_case_has_its_plots() -> None:
    (of_cases,) = SECTION.galleries
    galleries = of_cases(study())
    assert [head.split(":")[0] for head, _ in galleries] == [
        f"Case {n} of the notebook" for n in range(1, 8)
    ]
    for _, figures in galleries:
        course, plane = figures
        for figure in (course, plane):
            assert [t["name"] for t in figure.traces] == [
                "non-linear, exact", "RK4", "linear, exact", "RK4"
            ]  # fmt: skip
            spread = [abs(v) for v in figure.traces[0]["y"] if v is not None]
            assert max(spread) > 0.1
        inside = [v for v in plane.traces[0]["x"] if v is not None]
        assert max(map(abs, inside)) <= 3.142


def test_orders_are_those_predicted() -> None:
    found = orders.orders(study())
    assert found is not None
    for row in texts(found):
        for cell in row[1:]:
            if cell == "–":
                continue
            observed, predicted = cell.split("\n")
            slope, low, high = (float(v.strip("[],")) for v in observed.split())
            assert low <= slope <= high
            # terms beyond the four, and the nonlinear part at the coarsest steps
            assert slope == pytest.approx(float(predicted), abs=0.05)
    slopes = {row[0]: float(row[1].split()[0]) for row in texts(found)}  # of RK4
    assert slopes == pytest.approx({"free-small": 4.0, "free-large": 5.0}, abs=0.4)  # to 0.1 s
    assert orders.orders(replace(study(), convergence=())) is None


def test_a_held_control_costs_orders() -> None:
    rows = {row[0]: row for row in texts(orders.held_control(study()))}
    slopes = {name: float(row[2].split()[0]) for name, row in rows.items()}
    wanted = {"ode/rk4": 4.0, "mujoco/rk4": 1.0, "mujoco/rk4+midpoint": 2.0, "mujoco/euler": 1.0,
              "mujoco/euler+midpoint": 1.0}  # fmt: skip
    assert slopes == pytest.approx(wanted, abs=0.05)  # higher terms at these steps
    assert slopes == pytest.approx({n: float(r[3]) for n, r in rows.items()}, abs=2e-3)


def loss(method: str, step: float) -> float:
    """Rate [J/s] at which a joint loses energy, at any step [s]."""
    run = made(ExtraRun(energy.SCENE, method, step, energy.LOSS_SPAN))
    assert isinstance(run, Trajectory)
    return energy.loss_rate(run)


def test_energy_is_bounded_drifts_or_is_lost() -> None:
    _, _, drifts = energy.compared(study())
    assert {name for name, d in drifts.items() if d.secular} == {"ode/rk4", "pymunk/default"}
    rk4 = drifts["ode/rk4"]
    # a line through whole periods and a part of one: after 18 of them 0.3 % of the ripple remain
    assert rk4.rate == pytest.approx(rk4.predicted, rel=5e-3)
    assert energy.predicted_loss(1e-3) == pytest.approx(2 * energy.predicted_loss(5e-4))
    # the first term; the second is 5 % of it at 1e-3 s and halves with the step
    gaps = [1 - loss("pymunk/default", h) / energy.predicted_loss(h)
            for h in (1e-3, 5e-4, 2.5e-4)]  # fmt: skip
    assert gaps[0] == pytest.approx(0.055, abs=0.01)
    assert gaps[1:] == pytest.approx([gaps[0] / 2, gaps[0] / 4], rel=0.1)
    for iterations in (1, 50):
        again = energy.loss(study(), "pymunk/default", 1e-3, iterations)
        assert again == pytest.approx(loss("pymunk/default", 1e-3), rel=1e-6)
    cube = loss("pymunk/tight", 4e-3) / loss("pymunk/tight", 2e-3)
    assert math.log2(cube) == pytest.approx(3.0, abs=0.1)


@pytest.mark.parametrize(
    ("rate", "ripple", "fate"),
    [(-1.0, 0.0, "lost"), (1.0, 0.0, "gained"), (-0.02, 0.0, "secular"), (0.0, 0.1, "bounded")],
)
def test_what_becomes_of_an_energy(rate: float, ripple: float, fate: str) -> None:
    times = np.linspace(0.0, 1.0, 200)
    errors = rate * times + ripple * np.sin(40.0 * times)
    run = Trajectory(times, {}, {}, steps=199)
    found = Drift(run, tuple(errors.tolist()), rate, ripple, None, 0.0, available=1.0)
    assert found.fate == fate
    assert found.secular == (fate != "bounded")


def test_tension_of_the_rod() -> None:
    for row in texts(tension.finding(study())):
        own = float(row[5])
        assert own < 1e-13 if row[1].startswith("mujoco") else own > 1e-3
        if row[1] == "pymunk/tight":
            assert float(row[6]) < 0.1 * own  # the delay is the stated one


def test_how_long_a_reference_is_known() -> None:
    found = exactness.references(study())
    for row in texts(found):
        assert float(row[1]) < exactness.AGREED
    assert "1e-12 rad for 31 s, 1e-9 rad for 116 s" in found.summary


def test_next_to_the_top() -> None:
    rows = {int(row[0]): row for row in texts(exactness.near_top(nothing()))}
    assert float(rows[5][3]) > 6.0  # scipy's theta, by a turn
    assert rows[8][3] == "not a number"
    half_ulp = 2.0**-52  # rounding of a double between 2 and 4
    for k, row in rows.items():
        assert abs(float(row[4])) <= half_ulp * 10.0**k * 1.01
    found = exactness.hard(study(), find_scene("simple-pendulum/near-top-1e-6"))
    assert isinstance(found[0], Figure)
    assert isinstance(found[1], Table)
    rates = [float(row[1].text) for row in found[1].rows if row[1].text[0].isdigit()]
    # within 0.25 rad of the top the motion is linear in the distance to 3 %; it stays 4.1 s, the
    # rates are fitted to the second half, and a scheme's own error grows as t e^(rate t)
    assert rates
    assert all(0.97 < rate / math.sqrt(9.8) < 1.03 + 1 / (2.0 * math.sqrt(9.8)) for rate in rates)


def test_a_known_limit_is_strict() -> None:
    wanted = expected("capsule-line/ca1", "pymunk/pivots")
    assert wanted.verdict == "not-converging"
    scene = find_scene("capsule-line/ca1")
    how = find_methods("pymunk/pivots")[0]
    assert wanted.allows(Judgement("not-converging", {}, ""))
    assert not as_expected(scene, how, Judgement("pass", {}, ""))


def test_findings_name_commands_that_exist() -> None:
    for one in (exactness.near_top(nothing()), tension.finding(study()), notebook.finding(study())):
        for command in one.commands:
            words = command.split()
            assert words[0] == "plumbob"
            assert words[1] in ("run", "solve", "validate")
            names = words[words.index("--scenes") + 1] if "--scenes" in words else words[2]
            assert all(find_scene(name).name == name for name in names.split(","))


def test_the_notebooks_statements() -> None:
    found = claims.finding(declared(nothing(), notebook.requests))
    verdicts = {line[0].text: line[3].text for line in found.tables[0].rows}
    assert len(verdicts) == 14
    ours = {line[0].text: line[2].text for line in found.tables[0].rows}
    assert "solved exactly" in ours["equation of motion: mLθ̈ + CLθ̇ + mg sin θ = F(t)"]
    assert "11.5 % faster" in ours["case 3: the two are compared at 200°/s"]
    # theta_0^2/16 and the next term of the period's series, 11 theta_0^4/3072
    start = math.radians(10.0)
    series = start**2 / 16 + 11 * start**4 / 3072
    assert claims.lengthening("free-small") == pytest.approx(series, rel=1e-5)
    # the linear pendulum's amplitude; the start is forgotten as e^(-0.1 t)
    steady = 1.5 / math.hypot(9.8 - 2.8**2, 0.2 * 2.8)
    assert claims.forced("forced-large")[1] == pytest.approx(steady, rel=0.02)
    assert claims.forced("forced-large")[0] > 1.5
    ran = claims.parting(declared(nothing(), notebook.requests), "free-small")
    # the phases part by theta_0^2/16 of what has passed: amplitude * sin(omega t theta_0^2/16)
    by_phase = start * math.sin(math.sqrt(9.8) * 50.0 * start**2 / 16)
    assert ran.largest == pytest.approx(by_phase, rel=0.02)
    assert ran.relative == pytest.approx(0.295, abs=5e-3)
    assert ran.in_runs == pytest.approx(ran.largest, rel=5e-3)
    # a small damped swing keeps to the exponential up to its amplitude squared, a large one not
    assert 5e-4 < claims.decay("damped-small") < 1e-3
    assert 0.05 < claims.decay("damped-large") < 0.2
    assert "30 %" in found.summary


def test_the_equation_is_that_of_mujoco_s_multibody_model() -> None:
    ran = replace(study(), convergence=())
    assert claims._in_mujoco(ran) == "solved exactly"
    scene = find_scene("simple-pendulum/free-large")
    (how,) = find_methods(claims.MUJOCO)
    found = convergence_study(scene, how, 10_000, (1e-2, 5e-3))
    said = claims._in_mujoco(replace(ran, convergence=(found,)))
    assert said.endswith("rad at 0.005 s")
    assert float(said.split("within ")[1].split()[0]) < 1e-6


def test_the_bob_in_the_plane() -> None:
    found = bob.finding(declared(nothing(), notebook.requests))
    first = {line[0].text: line[3].text for line in found.tables[0].rows}
    assert first["1"] == first["5"] == "–"
    largest = {line[0].text: float(line[2].text) for line in found.tables[0].rows}
    assert largest["2"] == pytest.approx(2.0, rel=0.01)  # opposite ends of a diameter, L = 1
    over_x, over_y, plane = found.figures
    for axis, figure in enumerate((over_x, over_y)):
        exact, dots, *_ = figure.traces
        assert exact["y"][0] == pytest.approx((-math.sin(math.radians(120)), 0.5)[axis], rel=1e-3)
        near = np.interp(dots["x"], exact["x"], exact["y"])
        assert np.abs(near - np.array(dots["y"])).max() < 5e-3
    # within three periods of 2.76 s, as the summary says
    assert bob.distances(bob.FINE[:830], "free-large").max() > 1.9
    round_, swing = plane.traces
    assert np.hypot(round_["x"], round_["y"]) == pytest.approx(1.0, rel=1e-3)
    assert np.hypot(swing["x"], swing["y"]) == pytest.approx(0.97, rel=1e-3)
