"""Derivatives by differences of runs: their errors are the predicted ones, on both sides, and a
wrong engine or a wrong prediction is seen."""

from dataclasses import replace

import pytest

from plumbob.engines.adapters import integrators
from plumbob.engines.derivative_ways import FORWARD
from plumbob.engines.registry import method
from plumbob.engines.study import gradient as measuring
from plumbob.engines.study.gradient import GradientSearch
from plumbob.engines.study.order import fit_order
from plumbob.tests.peers.test_smooth_peers import needed
from plumbob.tests.support.derivatives import judgements

LINE, CONE = "capsule-line/heading-030", "cone-pendulum/rotating-base"
THERE = "mujoco/euler+coulomb"
SMOOTH = (
    (CONE, "ode/dop853", "theta", "theta"),
    (CONE, "mujoco/euler", "theta", "platform_rate"),
    (CONE, "mujoco/rk4", "theta", "theta_dot"),
    (CONE, "pymunk/torque", "theta", "theta_dot"),
    (CONE, "ode/leapfrog", "theta", "pivot_y"),
    ("cone-pendulum/fast-platform", "ode/rk4", "theta", "theta"),
    (CONE, "heyoka/taylor", "theta_dot", "gravity"),
    ("cone-pendulum/equal-wells-short", "ode/radau", "theta", "gravity"),
    ("free-body/flip", "ode/rk4", "angular_velocity_x", "inertia_x"),
    (LINE, "pymunk/feet", "displacement", "w1"),
    (LINE, "mujoco/euler+coulomb", "displacement", "friction"),
)

# An explicit scheme, an engine, a free body and friction; the others take a minute
IN_CI = (SMOOTH[1], SMOOTH[5], SMOOTH[8], SMOOTH[10])


def _records(search):
    return search.answer(method(search.method)).records


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "how", "of", "by"),
    [pytest.param(*pair, marks=[pytest.mark.rare] * (pair not in IN_CI)) for pair in SMOOTH],
)
def test_every_difference_of_a_sweep_has_the_predicted_error(name, how, of, by):
    """And the best difference is predicted within a factor of three."""
    needed(how)
    at = 2.0 if name == "free-body/flip" else None  # its exact derivatives take long
    sweep = GradientSearch(name, how, (of,), by, ("central", "forward"), at=at)
    found = _records(sweep)
    if "capsule" not in name:
        ratios = [of.measured_best / of.predicted_best for of in found]
        assert ratios == pytest.approx([1.0] * 2, rel=2.0)
        assert min(ratios) > 1 / 3
    eps = tuple(d.eps for d in found[0].tried if d.eps)
    judged = judgements(replace(sweep, eps=eps))
    assert len(judged) == 2 * len(measuring.DIFFERENCE_DISTANCES)
    wrong = [
        (j.gradient.way, j.tried and j.tried.eps, j.why)
        for j in judged
        if j.verdict == "off-prediction"
    ]
    assert not wrong
    assert sum(j.verdict == "predicted" for j in judged) >= 10


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    ("name", "how", "of", "by", "way", "eps"),
    [
        ("capsule-line/w1-threshold-short", THERE, "displacement", "friction", "central", 3e-8),
        ("capsule-coast/rotation", "pymunk/pivots", "heading", "velocity_x", "forward", 1e-7),
        ("capsule-coast/rotation", THERE, "heading", "velocity_x", "forward", 1e-7),
        ("capsule-plan/beside-curve-31", "pymunk/feet", "y", "friction", "central", 3e-6),
    ],
)
def test_errors_that_jump_are_left_open(name, how, of, by, way, eps, monkeypatch):
    """Of supports that stop within a step, or at its very end, and next to a motion in which all
    stop together."""
    search = GradientSearch(name, how, (of,), by, (way,), 1e-3, (eps,))
    assert [judged.verdict for judged in judgements(search)] == ["predicted"]
    monkeypatch.setattr(measuring, "JUMP", 0.0)
    monkeypatch.setattr(measuring._Runs, "corner", lambda *_: 0.0)
    assert [judged.verdict for judged in judgements(search)] == ["off-prediction"]


@pytest.mark.long
@pytest.mark.parametrize("how", ["dop853", "lsoda"])
def test_no_best_difference_is_predicted_where_steps_change_beside_it(how):
    """LSODA takes one step less at -1e-10, where its error jumps by 4e-11 rad."""
    sweep = GradientSearch("cone-pendulum/resting-base", f"ode/{how}", ("theta",), "theta")
    central, _ = _records(replace(sweep, ways=("central", "forward")))
    assert (central.predicted_best is None) == (how == "lsoda")
    assert 1e-5 < central.measured_best < 2e-5 or how == "lsoda"


@pytest.mark.parametrize("curved", [0.0, 1e-9])
def test_what_is_linear_in_a_parameter_has_no_best_difference(curved):
    errors = [curved * eps + 1e-15 / eps for eps in measuring.DIFFERENCE_DISTANCES]
    best = FORWARD.best_of_sweep(measuring.DIFFERENCE_DISTANCES, errors)
    assert (best is None) == (curved == 0.0)
    assert best is None or 3e-4 < best < 3e-3


@pytest.mark.long
def test_the_order_of_a_derivative_is_that_of_its_scheme():
    for how, order in (("mujoco/euler", 1), ("ode/leapfrog", 2), ("ode/rk4", 4)):
        steps = [4e-3, 2e-3, 1e-3, 5e-4]
        errors = []
        predicted = []
        for step in steps:
            search = GradientSearch(
                CONE, how, ("theta",), "platform_rate", ("central",), step, (1e-3,)
            )
            (record,) = _records(search)
            (tried,) = record.tried
            errors.append(abs(tried.computed - record.exact - tried.truncation))
            predicted.append(abs(tried.slope or 0.0))
        observed, expected = (fit_order(steps, e, [0.0] * 4) for e in (errors, predicted))
        assert observed
        assert expected
        assert observed.slope == pytest.approx(expected.slope, abs=0.01)
        assert order - 0.1 < observed.slope < order + 1.0


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("part", [1e-6, -1e-6])
def test_a_slightly_wrong_engine_is_off_its_prediction(part, monkeypatch):
    right = integrators.rk4
    monkeypatch.setattr(
        integrators, "rk4", lambda e, s, a, b, h: right(e, s, a, b, h * (1.0 + part))
    )
    (judged,) = judgements(
        GradientSearch(CONE, "ode/rk4", ("theta",), "gravity", ("central",), 1e-3)
    )
    assert judged.verdict == "off-prediction"
    assert judged.surprise


@pytest.mark.long
def test_where_no_derivative_exists_the_one_sided_ones_stand_beside():
    search = GradientSearch(
        "simple-pendulum/free-small",
        "ode/rk4",
        ("theta",),
        "damping_rate",
        ("central", "forward"),
        at=5.0,
    )
    central, forward = judgements(search)
    assert central.verdict == "unsupported"
    assert forward.verdict == "pre-asymptotic"
    assert "there is no derivative" in forward.why
    assert forward.gradient.one_sided
    assert forward.tried
    assert forward.tried.computed == pytest.approx(forward.gradient.one_sided[1], rel=1e-4)
