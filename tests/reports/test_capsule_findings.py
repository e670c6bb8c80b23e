"""Statements of the page on the capsule's line, holding, coasting and repeated manoeuvres hold."""

from dataclasses import fields, replace

import numpy as np
import pytest

from plumbob.analytic.systems.capsule import normal_forces
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.engines.study.cost import Cost
from plumbob.reports.analyses import capsule_train, mean_speed, section
from plumbob.reports.analyses.capsule_line import (
    displacement,
    drive,
    fidelity,
    source,
    source_text,
    tipping,
)
from plumbob.reports.analyses.measurements import CHECK_LINE, problem
from plumbob.reports.records.plain_data import FOR_TEMPLATES, plain
from plumbob.reports.view.finding_text import read_findings
from plumbob.tests.support.declared import (
    declared,
    finding,
    measured,
    nothing,
    numbers_of,
)
from plumbob.tests.support.declared import findings_of as formed_of

METHODS = ("mujoco/euler", "mujoco/euler+coulomb", "mujoco/euler+reduced", "pymunk/side")
EXACT = -0.0055917  # [m], eq. 22 at physics' check values


def study(scene, *steps):
    """A scene with some methods at a few steps, and no costs."""
    return measured(scene, METHODS, *steps)


def test_figure_of_the_source():
    check = numbers_of(source.FIGURE_2)
    (gallery,) = read_findings(source.FIGURE_2.template, plain(check, FOR_TEMPLATES))
    # exact, and two engines
    assert [len(panel.traces) for panel in gallery.figures] == [3, 3, 3]
    v, v_c, x = (check.exact[name] for name in source.FIGURE_2_OBSERVABLES)
    assert max(v) == pytest.approx(1.14777, rel=1e-3)
    assert min(v_c) == pytest.approx(-0.17658, rel=1e-3)
    assert x[-1] == pytest.approx(EXACT, rel=1e-3)
    for name in source.FIGURE_2_OBSERVABLES[:2]:  # dots on the curve of that corner
        corner = max(check.exact[name], key=abs)
        assert max(check.engines[source.FIGURE_METHOD][name], key=abs) == pytest.approx(
            corner, rel=0.02
        )


def test_errors_are_the_sawtooth_of_the_step():
    numbers = numbers_of(displacement.DISPLACEMENT_ERRORS, study(CHECK_LINE, 1e-3, 1e-4))
    errors = {method.method: method.errors[:2] for method in numbers.methods}
    for name, most in (
        ("mujoco/euler+reduced", 1.01),
        ("pymunk/side", 1.01),
        ("mujoco/euler+coulomb", 1.08),
    ):
        for error, predicted in zip(errors[name], numbers.predicted, strict=False):
            assert 0.99 < error / predicted < most
    assert min(errors["mujoco/euler"]) > 0.02
    assert displacement.displacement_errors(nothing()) is None


def test_heights():
    heights = numbers_of(fidelity.HEIGHTS)
    assert heights.shift == pytest.approx(1.2, abs=0.05)
    coarse, fine = heights.changes
    assert coarse < 3e-4
    assert fine < 4e-6


def test_a_brake_beyond_the_limit_turns_the_body_round():
    """The exact motion against constant accelerations; at the limit nothing is left of it."""
    line = problem(CHECK_LINE).motion
    for factor in (1.2, 2.0, 5.0):
        found = source_text.hard_brake(line, factor)
        assert found.after == pytest.approx(found.formula, rel=1e-10)
        assert found.back < 0.0 < found.after
    # by hand, with SI numbers: -(1/2) (mu w1 - fg) t1 t*, mu = 0.3/1.3, w1 = 3 fg/mu, w2 = 2 fg/mu
    decay = 0.3 * 9.81
    assert source_text.hard_brake(line).back == pytest.approx(-decay * 0.03 * 0.05, rel=1e-9)
    # (1/2) 1e-3 fg (0.06 s)^2
    assert 0.0 < source_text.hard_brake(line, 1.0 + 1e-3).after < 6e-6


def test_what_else_the_source_says_of_lines():
    statements = finding(source_text.LINE_SOURCE_TEXT, study(CHECK_LINE, 1e-3)).statements
    assert {statement.verdict for statement in statements} == {"holds", "extended"}
    ours = {statement.place: statement.ours for statement in statements}
    assert "2.5 % with default contacts" in ours["(1)"]
    assert ours["(17), (20), Fig. 2"] == "0.03, 0.0633333, 0.1425 s"
    line = problem(CHECK_LINE).motion
    assert source_text.time_exponents(line) == pytest.approx((2.0, 2.0), abs=1e-12)
    assert source_text.balance_residual(line) < 1e-11

    class Rough(LineManoeuvre):
        """A friction that is not that of the motion."""

        def friction_force(self, times):
            return super().friction_force(times) * (1 + 1e-6)

    given = {field.name: getattr(line, field.name) for field in fields(line)}
    assert source_text.balance_residual(Rough(**given)) > 1e-8


def findings_of(system, given):
    own = section(system)
    return formed_of(own, declared(given, own.requests))


def test_repeated_manoeuvres():
    ran = study("capsule-train/ten", 1e-3)
    found = capsule_train.numbers(ran)
    totals = {total.method: total for total in found.totals}
    reduced = totals["mujoco/euler+reduced"]
    assert reduced.error == pytest.approx(reduced.predicted, rel=0.01)
    assert totals["mujoco/euler+coulomb"].error < 1.2e-4
    assert totals["mujoco/euler"].error > 0.02
    costs = {(c.scene, c.method): Cost(1e3, 1e3, 1e3, 1.0, 0.0, 5) for c in ran.convergence}
    timed = finding(capsule_train.TOTAL, replace(ran, costs=costs))
    assert {line[-1].text for line in timed.tables[0].rows} == {"320 µs"}  # 320 steps of 1 µs
    # The finding on the mean speed needs no run.
    assert [one.name for one in findings_of("capsule-train", nothing())] == [
        "capsule-mean-speed"
    ]


def test_what_sizes_an_actuator():
    force = numbers_of(drive.DRIVE, measured(CHECK_LINE, METHODS))
    peak = force.line.peak
    turns = force.turns
    assert peak == pytest.approx(9.7119, rel=1e-3)
    assert turns["0.1"].peak == pytest.approx(3805.17, rel=1e-3)
    # centripetal force: 1/epsilon^2
    assert turns["0.03"].peak / turns["0.1"].peak == pytest.approx(1 / 0.09, rel=0.01)
    assert len(force.engines) == 2
    assert max(force.forces) == pytest.approx(9.7119, rel=1e-3)
    assert min(force.forces) == pytest.approx(-3.06072, rel=1e-3)


def test_the_exact_condition_for_contact_and_beyond():
    ran = declared(study(CHECK_LINE, 1e-3), tipping.requests)
    numbers = tipping.numbers(ran)
    assert numbers.reach == pytest.approx(4.33, abs=5e-3)
    motions = (numbers.check, numbers.edge, numbers.outside)
    inside = [(motion.com_inside, motion.slider_inside) for motion in motions]
    assert inside == [(True, True), (True, False), (False, True)]
    assert min(motion.lowest for motion in motions) > 0.0
    tipped = ran.answer(tipping.TIPPED)
    line = problem(tipping.NEAR_EDGE_SCENE).motion
    lifted = tipped.times[np.argmax(tipped.channels["contacts"] < 3)]
    # below zero statics asks for a pull, which a plane that only pushes cannot give
    places = (line.start + tipping.START_BEYOND_EDGE + line.at(tipped.times).stroke)[
        :, None
    ] * line.unit
    needed = normal_forces(line.capsule, places)[:, 0]
    # a foot leaves the plane then, within the contacts' delay
    assert lifted == pytest.approx(tipped.times[np.argmax(needed < 0.0)], abs=2e-3)
    assert tipped.observables["normal_force_1"][-1] == 0.0
    assert numbers.lift.risen > 1e-4


def test_the_fastest_manoeuvres():
    found = mean_speed.numbers()
    assert found.limit == pytest.approx(0.054, abs=5e-4)
    assert found.checked < found.pushed < found.limit < found.most
