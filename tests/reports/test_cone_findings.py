"""Statements of the page on the cone pendulum's source and its hard cases hold."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.reports.findings.cone_pendulum import (
    energy,
    hamiltonian,
    source_claims,
    source_figures,
)
from plumbob.reports.findings.cone_pendulum.hamiltonian import ROTATING, forms
from plumbob.reports.findings.energy_drift import drift_table
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
