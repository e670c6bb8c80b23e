"""Statements of the page on the cone pendulum's source hold."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbob.reports.analyses.cone_pendulum import (
    action_phase,
    drive_work,
    equilibria,
    generating_solution,
    hamiltonian,
    source_claims,
    source_figures,
    source_text,
    symmetry,
    uniformity,
)
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    ROTATING,
    closed_forms,
    turning_cone,
)
from plumbob.reports.records.exact_numbers import exact_numbers_of
from plumbob.reports.records.plain_data import FOR_TEMPLATES, plain
from plumbob.reports.view.finding_text import findings_of, read_findings
from plumbob.tests.support.declared import declared, finding, nothing, numbers_of
from plumbob.tests.support.studies import quick


def stored(analysis):
    """An analysis with the numbers that the study measured for all tests has of it."""
    return next(of for of in quick().analyses if of.template == analysis.template)


def shipped(analysis):
    """The numbers of an analysis that are shipped with the package."""
    return exact_numbers_of(analysis.template).numbers


def test_finding_printed_hamiltonian():
    found = numbers_of(hamiltonian.PRINTED)
    # Difference between Sudakov's eqs. 7 and 9 at 0.5 s, integrated with 40 digits.
    assert found.gap == pytest.approx(6.27, abs=5e-3)
    assert len(found.runs) == 2
    assert found.worst < 1e-11  # the errors of RK4 at 1e-4 and DOP853 at 1e-13
    assert (
        found.runs["mujoco"].correct_varies
        < 1e-8
        < 1000.0
        < found.runs["mujoco"].printed_varies
    )


def test_figures_of_the_source_begin_at_the_start():
    numbers = numbers_of(source_figures.GALLERIES)
    _, turning = read_findings(source_figures.TEMPLATE, plain(numbers, FOR_TEMPLATES))
    (*_, momentum, speed) = turning.figures
    problem = closed_forms(ROTATING).problem
    assert speed.traces[0]["y"][0] == pytest.approx(problem.theta_dot, rel=1e-3)
    moment = problem.body.inertia_x * problem.theta_dot
    assert momentum.traces[0]["y"][0] == pytest.approx(moment, rel=1e-3)


def test_finding_inertia():
    found = numbers_of(symmetry.INERTIA)
    theta = [found.exact, found.without, found.runs["mujoco"]]
    assert theta == pytest.approx([19.729448, 19.655093, 19.729448], abs=1e-6)


def test_finding_symmetry():
    found = numbers_of(symmetry.PRODUCT_OF_INERTIA)
    assert found.moved == pytest.approx(-0.00513060, rel=1e-3)
    assert len(found.gaps) == 3
    assert found.worst < 1e-11  # the errors of RK4 at 1e-4 and DOP853 at 1e-13
    # the pivot along and above the axis does not matter
    assert found.carried < 1e-11


def test_claims_in_numbers():
    turning = closed_forms(ROTATING)
    right = source_text.rotation_over_top(turning.correct)
    printed = source_text.rotation_over_top(turning.printed)
    assert (right.lowest, right.highest) == pytest.approx((33.45358, 49.40424), abs=1e-4)
    assert (right.spread, printed.spread) == pytest.approx((0.4311, 0.7161), abs=1e-4)
    # From energy only: 37 rad/s at the bottom, on a resting base, to the top.
    level = replace(turning.problem, platform_rate=0.0)
    arm = level.body.mass * level.body.com_distance * level.gravity
    top = math.sqrt(37.0**2 - 4 * arm / level.body.inertia_x)
    assert source_text.rotation_over_top(level.motion).spread == pytest.approx(
        (37.0 - top) / 37.0, abs=1e-6
    )


def test_finding_uniformity():
    """Three verdicts, and maps that agree with them."""
    measures = shipped(uniformity.UNIFORMITY)
    assert not measures["shrinks"]
    still, better, *_ = (point["exact"] for point in measures["points"])
    assert better["deviation"] < still["deviation"]
    assert better["near"] > still["near"]
    for each in measures["maps"]:
        assert np.nanmin(each["spread"]) > 1 - 1e-12
        at_rest = next(zip(*each["deviation"], strict=True))
        assert np.asarray(at_rest) == pytest.approx(1.0, rel=1e-12)
        assert 0.0 < each["steadier"] < 1.0
        assert 0.0 < each["nearer"] < 1.0
        # If the whole period is near the initial speed, or no part of it, the difference is
        # rounding, 4e-16 at most; elsewhere it is 1e-4 of the period and more.
        assert each["nearer"] == np.mean(np.asarray(each["time"]) < -1e-6)


def test_finding_action_and_phase():
    starts = stored(action_phase.ACTION_PHASE).numbers["starts"]
    assert len(starts) == len(action_phase.WELLS_AND_SPEEDS)
    for start in starts:
        # RK4 at 2e-4 s, and a cubic between 160 samples a period: (2 pi/160)^4/384, relative
        assert start["measured"] == pytest.approx(start["period"], rel=1e-8)
        assert start["drift"] < 1e-9


def test_finding_equilibria():
    numbers = stored(equilibria.EQUILIBRIA).numbers
    assert (numbers["fork"], numbers["node"]) == pytest.approx((6.44823, 11.2938), abs=5e-5)
    assert len(numbers["centres"]) == 15
    assert numbers["largest_gap"] < 1e-6  # the amplitude's
    near, far = (
        turning_cone(pivot_y=0.0, platform_rate=rate).equilibria[0].rate
        for rate in (8.0, 8.001)
    )
    assert abs(near / far - 1.0) > 1e-4  # what a platform rate wrong by 1e-4 would change


def test_finding_generating_solution():
    solutions = stored(generating_solution.GENERATING_SOLUTION).numbers
    for drive in solutions["drives"]:
        # the next order: J/A, J at most 1.68 kg m^2
        assert abs(drive["gap"]) < 1.0 / drive["inertia"]


def test_what_else_the_source_says():
    (found,) = findings_of(stored(source_text.SOURCE_TEXT))
    said = {(s.place, s.verdict): s.ours for s in found.statements}
    assert len(found.statements) == 19
    assert "11 of 19" in found.summary
    second = next(s for s in found.statements if s.text.startswith("In the second half"))
    # the source's own comparison, of its Fig. 3 with its Fig. 2, by its printed H and by the right
    assert second.verdict == "holds"
    assert second.said == "by 45 % by the printed H, against 78 % in Fig. 2"
    assert second.ours == "by 12 %; at rest from the same speed 6 %"
    assert "another speed" in second.why
    # energies alone: 13^2 less 4 M g S/I_x at the top
    slowest = math.sqrt(13.0**2 - 4 * 35.80930299751591 / 0.89270329145737231)
    assert said["Fig. 2 e", "holds"].startswith(f"{slowest:.4f} rad/s at 0.500 T")
    assert said["Fig. 2 e", "refuted"].endswith("35.81 N m, is at θ = 0.5 π")
    assert "39.253 rad/s (7.0346 rad/s at rest" in said["Fig. 3 b", "corrected"]
    assert said["Fig. 3 c", "holds"].startswith(
        "4 extremes of the speed in a period, 2 at rest"
    )
    assert "does 0 J of work in all, gravity's -71.62 J" in said["Fig. 3 e", "corrected"]
    # I_x of (1), and the period of Fig. 2 without and with the factor 2
    assert said["(16)", "corrected"].startswith("I_x: p ∂p/∂H is 0.8927 kg m², and")
    assert said["(16)", "corrected"].endswith("comes round in 0.893188 s")
    assert "T, 2 T, 3 T after" in said["numerical experiment", "corrected"]
    assert said["Fig. 3 b", "holds"].endswith("crosses it 1 time within a turn (1 at rest)")
    assert "0.051 (0.111 at rest)" in said["Fig. 3 b", "holds"]


def test_the_vectors_of_equation_4_point_the_other_way():
    problem = closed_forms(ROTATING).problem
    given = source_text.triple_products(problem)
    assert given.as_written == pytest.approx(-215.879309840209, rel=1e-13)
    assert given.opposite == pytest.approx(given.formula, rel=1e-15)
    # by components: M ω S (Y ω sin θ + X θ' cos θ), M S of (1)
    arm = 16.240046710891569 * 0.225
    parts = 0.09 * 26 * math.sin(0.7) + 0.2 * 5.0 * math.cos(0.7)
    assert given.formula == pytest.approx(26 * arm * parts, rel=1e-14)


def test_a_period_is_one_mean_and_few_points():
    turning = closed_forms(ROTATING)
    mean = source_text.period_by_means(turning.correct)
    assert mean == pytest.approx(0.16006944027755794, rel=1e-14)  # 40 digits
    assert source_text.period_by_means(turning.printed) == pytest.approx(
        0.23698083024728754, rel=1e-14
    )
    other = replace(turning.problem, platform_rate=26.0 * (1 + 1e-9)).motion
    assert abs(source_text.period_by_means(other) / mean - 1.0) > 1e-11
    assert source_text.points_needed(turning.correct) == 32
    sums = [source_text.period_by_points(turning.correct, n) / mean - 1.0 for n in (8, 16, 32)]
    assert abs(sums[0]) > 1e-5 > abs(sums[1]) > 1e-12 > abs(sums[2])


def test_parts_of_the_energy_and_the_drive():
    study = declared(nothing(), drive_work.DRIVE_WORK.requests)
    work = drive_work.numbers(study)
    carried = 16.24 * 26.0**2 * 0.09**2 / 2  # M w^2 Y^2/2 and M Y S w^2
    assert work.extremes["translation"] == pytest.approx((carried, carried), rel=1e-5)
    coupled = 16.24 * 0.09 * 0.225 * 26.0**2
    assert work.extremes["coupling"] == pytest.approx((-coupled, coupled), rel=1e-5)
    assert work.others == 0.0
    # DOP853 at 1e-13 on the source's equation, and the rate of the angular momentum as its
    # fourth-order difference over 1e-5 s
    assert work.torque == pytest.approx(1554.5498518844, abs=0.005)
    # a reaction of a constraint is no applied force: the source is right, and it is not all
    verdicts = [
        statement.verdict for statement in finding(drive_work.DRIVE_WORK, study).statements
    ]
    assert verdicts == ["refuted", "holds", "holds", "extended"]


def test_where_the_source_is_right_it_is_said_so():
    (claims,) = findings_of(stored(source_claims.CONE_CLAIMS))
    said = {one.text: one for one in claims.statements}
    rises = next(one for text, one in said.items() if "rises to 514.197 J" in text)
    assert rises.verdict == "corrected"
    assert "It rises" in rises.why
    assert "300 equally spaced angles, 514.197 J" in rises.why
    study = declared(nothing(), symmetry.INERTIA.requests)
    found = finding(symmetry.INERTIA, study)
    assert found.judgement == "extended"
    assert [one.verdict for one in found.statements] == ["extended"]
