"""Statements of the page on the cone pendulum's source and its hard cases hold."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbob.analytic.reference import Array
from plumbob.engines.study.cost import Cost
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.reports.analyses.cone_pendulum import (
    action_phase,
    drive_work,
    energy,
    equilibria,
    generating_solution,
    hamiltonian,
    series,
    source_claims,
    source_figures,
    source_text,
    symmetry,
    uniformity,
)
from plumbob.reports.analyses.cone_pendulum.hamiltonian import ROTATING, forms
from plumbob.reports.analyses.energy_drift import drift_table, overtaken
from plumbob.reports.analyses.measurements import extremes, largest
from plumbob.tests.support.declared import declared, nothing
from plumbob.tests.support.studies import quick


def test_finding_printed_hamiltonian() -> None:
    found = hamiltonian.finding(declared(nothing(), hamiltonian.requests))
    # Difference between Sudakov's eqs. 7 and 9 at 0.5 s, integrated with 40 digits.
    assert "6.27 rad" in found.summary
    mutual = [float(line[1].text) for line in found.tables[1].rows]
    assert len(mutual) == 3
    assert max(map(abs, mutual)) < 1e-11  # the errors of RK4 at 1e-4 and DOP853 at 1e-13
    correct, printed = (float(cell.text) for cell in found.tables[2].rows[0][1:])
    assert correct < 1e-8 < 1000.0 < printed


def test_figures_of_the_source_begin_at_the_start() -> None:
    (*_, momentum, speed) = source_figures.panels(
        declared(nothing(), source_figures.requests), ROTATING
    )
    problem = forms(ROTATING).problem
    assert speed.traces[0]["y"][0] == pytest.approx(problem.theta_dot, rel=1e-3)
    moment = problem.body.inertia_x * problem.theta_dot
    assert momentum.traces[0]["y"][0] == pytest.approx(moment, rel=1e-3)


def test_finding_inertia() -> None:
    (table,) = source_claims.inertia(declared(nothing(), source_claims.requests)).tables
    theta = [float(line[1].text) for line in table.rows]
    assert theta == pytest.approx([19.729448, 19.655093, 19.729448], abs=1e-6)


def test_finding_symmetry() -> None:
    found = symmetry.finding(declared(nothing(), symmetry.requests))
    _, without, *engines = (float(line[2].text) for line in found.tables[0].rows)
    assert without == pytest.approx(-0.00513060, rel=1e-3)
    assert len(engines) == 3
    assert max(map(abs, engines)) < 1e-11  # the errors of RK4 at 1e-4 and DOP853 at 1e-13


def test_claims_in_numbers() -> None:
    turning = forms(ROTATING)
    right, printed = source_claims.speeds(turning.correct), source_claims.speeds(turning.printed)
    assert (right.lowest, right.highest) == pytest.approx((33.45358, 49.40424), abs=1e-4)
    assert (right.spread, printed.spread) == pytest.approx((0.4311, 0.7161), abs=1e-4)
    # From energy only: 37 rad/s at the bottom, on a resting base, to the top.
    level = replace(turning.problem, platform_rate=0.0)
    arm = level.body.mass * level.body.com_distance * level.gravity
    top = math.sqrt(37.0**2 - 4 * arm / level.body.inertia_x)
    assert source_claims.speeds(level.motion).spread == pytest.approx((37.0 - top) / 37.0, abs=1e-6)


def test_energy_is_bounded_or_drifts_as_predicted() -> None:
    given = declared(nothing(), energy.requests)
    _, _, drifts = drift_table(given, energy.RUNS, forms(ROTATING).correct)
    assert {name for name, d in drifts.items() if d.secular} == {"mujoco/rk4"}
    drift = drifts["mujoco/rk4"]
    # A line through whole turns and a part of one does not average the oscillation out: 0.2 %.
    assert drift.rate == pytest.approx(drift.predicted, rel=0.005)
    assert drift.round_off < 1e-3 * abs(drift.rate)


def test_when_a_drift_exceeds_the_oscillation_of_others_is_said() -> None:
    given = declared(nothing(), energy.requests)
    _, _, drifts = drift_table(given, energy.RUNS, forms(ROTATING).correct)
    said = overtaken(drifts, energy.METHODS[:2], energy.METHODS[2])
    rate, swing = abs(drifts["mujoco/rk4"].rate), drifts["mujoco/euler"].scatter
    assert 10.0 < swing < 11.0  # [J]: a drift of 5 µJ/s takes three weeks
    assert "exceeds the oscillation of mujoco/euler (10 J) after 2e6 s and that of ode/l" in said
    assert swing / rate == pytest.approx(2.0e6, rel=0.02)
    assert "in a shorter run its energy error is the smaller one" in said
    assert energy.finding(given).summary.startswith(said)
    assert overtaken(drifts, energy.METHODS[:2], "ode/rk4") == ""  # not run
    late = {**drifts, "mujoco/euler": replace(drifts["mujoco/euler"], scatter=2.0 * swing)}
    assert "(21 J) after 4e6 s" in overtaken(late, energy.METHODS[:2], energy.METHODS[2])


@pytest.mark.long
def test_errors_grow_at_the_saddle_s_rate() -> None:
    scene = find_scene("cone-pendulum/above-barrier-1e-6")
    plot, table = energy.hard(quick(), scene)
    assert hasattr(plot, "traces")
    assert hasattr(table, "rows")
    rate = max(e.rate for e in system_of(scene).problem(scene.parameters).equilibria[:1])
    fitted = [float(line[1].text) for line in table.rows if line[1].text[0].isdigit()]
    assert len(fitted) >= 3
    # The neighbourhood of 0.25 rad is linear to 3 %, and so are the rates in it.
    assert fitted == pytest.approx([rate] * len(fitted), rel=0.03)


def test_finding_uniformity() -> None:
    """Three verdicts, MuJoCo beside the closed form, and maps that agree with it."""
    found = uniformity.finding(declared(nothing(), uniformity.requests))
    assert [line[1].text for line in found.tables[0].rows] == [
        "refuted", "holds in a regime", "holds in a regime",
    ]  # fmt: skip
    for line in found.tables[1].rows:
        exact, seen = ([float(cell.text) for cell in line[i : i + 3]] for i in (1, 4))
        # a recorded turn ends within a step of its period, 1e-3 of it, and has 500 samples
        assert seen == pytest.approx(exact, rel=2e-3, abs=2e-3)
    for one in map(uniformity.over_rates, uniformity.PIVOTS):
        assert np.nanmin(one.by_spread) > 1 - 1e-12
        at_rest = one.turning.deviation[:, 0]
        assert at_rest == pytest.approx(one.resting.deviation[:, 0], rel=1e-12)


@pytest.mark.long
def test_finding_action_and_phase() -> None:
    given = declared(nothing(), action_phase.requests)
    found = action_phase.finding(given)
    points = action_phase.measured(given)
    assert len(points) == len(action_phase.STARTS)
    for point in points:
        assert point.seen is not None
        # RK4 at 2e-4 s, and a cubic between 160 samples a period: (2 pi/160)^4/384, relative
        assert point.seen == pytest.approx(point.exact, rel=1e-8)
        assert point.drift is not None
        assert point.drift < 1e-9
    swings = [float(line[4].text) for line in found.tables[1].rows]
    assert max(map(abs, swings[:5])) < 1e-8  # RK4
    assert max(map(abs, swings[5:9])) < 1e-4 < 1e-2 > abs(swings[9])  # h^2; 0.04 rad from the top


def test_finding_equilibria() -> None:
    numbers = equilibria.numbers(declared(nothing(), equilibria.requests))
    assert (numbers.fork, numbers.node) == pytest.approx((6.44823, 11.2938), abs=5e-5)
    assert len(numbers.centres) == 15
    assert numbers.largest_gap is not None
    assert numbers.largest_gap < 1e-6  # the amplitude's
    near, far = (equilibria.still(0.0, rate).equilibria[0].rate for rate in (8.0, 8.001))
    assert abs(near / far - 1.0) > 1e-4  # what a platform rate wrong by 1e-4 would change


def test_finding_work_of_the_drive() -> None:
    found = drive_work.finding(declared(nothing(), drive_work.requests))
    (constant, own, given) = found.tables[0].rows[1:]
    assert float(constant[1].text) < 1e-9
    # the platform's rate changes by 2.4e-7 of 26 rad/s: 1e-8 of T; its energy has 4e-6 J of digits
    assert float(own[2].text) < 1e-4
    assert float(given[2].text) < 1e-3
    assert float(own[1].text) > 1000.0


@pytest.mark.long
def test_finding_generating_solution() -> None:
    found = generating_solution.finding(declared(nothing(), generating_solution.requests))
    damping, drives = found.tables
    offs = [float(line[3].text) for line in damping.rows]
    assert len(offs) == 3
    assert offs[0] / offs[2] == pytest.approx(4.0, rel=0.3)  # of the order of xi
    gaps = [float(line[4].text) for line in damping.rows]
    assert gaps == pytest.approx([gaps[0]] * 3, rel=0.05)  # of order 1
    assert abs(gaps[0]) < 0.1
    for line in drives.rows:
        inertia, *_, gap = (float(cell.text) for cell in line)
        assert abs(gap) < 1.0 / inertia  # the next order: J/A, J at most 1.68 kg m^2


def test_finding_series() -> None:
    found = series.finding(nothing())
    for line in found.tables[0].rows:
        harmonics = [int(cell.text) for cell in line[2:]]
        assert harmonics == sorted(harmonics)
    near = [int(line[-1].text) for line in found.tables[0].rows[2:]]
    assert near == sorted(near)
    assert near[-1] > 2 * near[0]
    assert [line[3].text for line in found.tables[1].rows] == ["–"] * 6
    assert "costs" not in found.summary
    cost = Cost(500.0, 500.0, 500.0, 1.0, 0.0, 5)
    timed = replace(nothing(), costs={(ROTATING, m): cost for m in (series.EXACT, series.STEPPED)})
    assert "A sample of the closed form costs 500 ns" in series.finding(timed).summary


def test_what_else_the_source_says() -> None:
    found = source_text.finding(nothing())
    said = {(s.place, s.verdict): s.ours for s in found.statements}
    assert len(found.statements) == 13
    assert "9 of 13" in found.summary
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
    assert said["Fig. 3 c", "holds"].startswith("4 extremes of the speed in a period, 2 at rest")
    assert "does 0 J of work in all, gravity's -71.62 J" in said["Fig. 3 e", "corrected"]


def test_a_period_is_one_mean_and_few_points() -> None:
    turning = forms(ROTATING)
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


def test_parts_of_the_energy_and_the_drive() -> None:
    found = drive_work.finding(declared(nothing(), drive_work.requests))
    _, parts, swing, external = found.statements
    assert "44.5, -222 to 222" in parts.ours  # M w^2 Y^2/2 and M Y S w^2, by hand
    assert pytest.approx(44.5, rel=1e-3) == 16.24 * 26.0**2 * 0.09**2 / 2
    assert pytest.approx(222.0, rel=2e-3) == 16.24 * 0.09 * 0.225 * 26.0**2
    assert swing.verdict == "holds"
    # a reaction of a constraint is no applied force: the source is right, and it is not all
    assert external.verdict == "extended"
    assert f"up to {largest_torque():.2f} N m" in external.ours
    assert f"{largest_torque():.1f}" == "1554.5"


def largest_torque() -> float:
    """Largest torque of the drive [N m] within 0.5 s: theta of the source's equation by a solver of
    scipy's, and the rate of the angular momentum as the fourth-order difference of it."""
    mass, arm = 16.240046710891569, 16.240046710891569 * 0.225
    about_x, about_z = 0.89270329145737231, 0.031481538138455129
    a, b, c = 0.5 * (about_x - about_z) * 26.0**2, arm * 0.09 * 26.0**2, arm * 9.8
    assert mass * 0.3 == pytest.approx(arm / 0.75)

    def rates(_: float, state: Array) -> list[float]:
        theta, rate = state
        moment = 2 * a * math.sin(theta) * math.cos(theta) + b * math.cos(theta)
        return [rate, (moment - c * math.sin(theta)) / about_x]

    h = 1e-5
    times = np.arange(0.0, 0.5 + 0.5 * h, h)
    solved = solve_ivp(rates, (0.0, 0.5), [0.0, 37.0], "DOP853", times, rtol=1e-13, atol=1e-13)
    theta = solved.y[0]
    momentum = 26.0 * (2 * arm * 0.09 * np.sin(theta) + (about_x - about_z) * np.sin(theta) ** 2)
    torque = (momentum[:-4] - 8 * momentum[1:-3] + 8 * momentum[3:-1] - momentum[4:]) / (12 * h)
    return float(np.abs(torque).max())


def test_the_largest_is_that_of_the_motion_and_not_of_its_samples() -> None:
    times = np.linspace(0.0, 1.0, 21)  # the two highest samples are not beside the highest peak

    def wave(t: Array) -> Array:
        return np.asarray(np.sin(8 * np.pi * t + 0.1) - 1e-3 * t)

    peaks = (np.pi * np.array([0.5, 2.5, 4.5, 6.5]) - 0.1) / (8 * np.pi)
    low, high = extremes(wave, times)
    assert high == pytest.approx(float(wave(peaks).max()), abs=1e-9)
    assert low == pytest.approx(-1.0 - 1e-3 * (7.5 * np.pi - 0.1) / (8 * np.pi), abs=1e-9)
    assert high - wave(times).max() > 1e-3
    assert largest(lambda t: t**2 - 5.0, np.array([0.0, 1.0, 2.0])) == 5.0  # at an end


def test_where_the_source_is_right_it_is_said_so() -> None:
    said = {one.text: one for one in source_claims.claims(nothing()).statements}
    rises = next(one for text, one in said.items() if "rises to 514.197 J" in text)
    assert rises.verdict == "corrected"
    assert "It rises" in rises.why
    assert "300 equally spaced angles, 514.197 J" in rises.why
    found = source_claims.inertia(declared(nothing(), source_claims.requests))
    assert found.judgement == "extended"
    assert [one.verdict for one in found.statements] == ["extended"]


def test_the_pivot_along_and_above_the_axis_does_not_matter() -> None:
    _, found = symmetry.finding(declared(nothing(), symmetry.requests)).statements
    carried = float(found.ours.split()[-2])
    assert carried < 1e-11
