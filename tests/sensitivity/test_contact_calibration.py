"""The calibrated factors of soft contacts are tested from both sides: runs refute smaller ones,
larger ones give bounds that are too loose."""

from dataclasses import replace
from functools import cache

import pytest

from plumbob.analytic.errors.contact_models import soft_contact
from plumbob.engines.adapters.mujoco import ENGINE
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene, system_of
from plumbob.reports.judge.verdict import judge
from plumbob.tests.support.cases import beyond
from plumbob.tests.support.mujoco_capsule import LOADS, METHODS

QUASI_STATIC, OVERSHOOT = "QUASI_STATIC_FACTOR", "OVERSHOOT_FACTOR"
LOOSE = {"loads": 15.0, "displacement": 6.0, "turn": 8.0}
LINE = ("capsule-line/at-123", "rk4+coulomb", 1e-3)
OFF_CENTROID = ("capsule-line/off-centroid", "euler+coulomb", 1e-3)
TURNS = tuple((f"capsule-turn/{ratio}", "euler+coulomb", 100) for ratio in (0.3, 0.1, 0.03))
HEAVY = tuple(("capsule-turn/heavy-slider", f"{m}+coulomb", 200) for m in ("euler", "rk4"))


@cache
def measured(run):
    """A run, independent of the factors."""
    name, method, step = run
    chosen = scene(name)
    if step >= 1.0:
        step = float(chosen.parameters["half_time"]) / step
    case = case_of(chosen)
    return case, measure(case, METHODS[method], step)[0]


def again(run):
    """The run with bounds from the present factors."""
    case, found = measured(run)
    bounds = ENGINE.model_error(case, METHODS[run[1]], found.step)
    errors = {
        name: replace(error, model=bounds.get(name, {})) for name, error in found.errors.items()
    }
    return replace(found, errors=errors)


def verdict(run):
    """The verdict on a run with the present factors."""
    return judge(again(run), system_of(scene(run[0])), METHODS[run[1]]).verdict


def looseness(run):
    """{observable: model-error bound over the unpredicted error}."""
    return {
        name: sum(error.model.values()) / beyond(error)
        for name, error in again(run).errors.items()
        if name in ("body_angle", "displacement", *LOADS) and error.predicted and beyond(error)
    }


@pytest.mark.long(keep=3)
@pytest.mark.parametrize("run", [LINE, OFF_CENTROID, *TURNS, *HEAVY])
def test_with_the_present_factors_runs_pass_and_bounds_are_not_loose(run):
    assert verdict(run) == "predicted"
    if run[0].startswith("capsule-turn"):
        assert 1.0 <= looseness(run)["body_angle"] < LOOSE["turn"]
    else:
        assert 1.0 <= looseness(run)["displacement"] < LOOSE["displacement"]
        assert all(1.0 <= looseness(run)[name] < LOOSE["loads"] for name in LOADS)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("run", HEAVY)
def test_a_quarter_of_the_quasi_static_factor_is_refuted(run, monkeypatch):
    monkeypatch.setattr(soft_contact, QUASI_STATIC, soft_contact.QUASI_STATIC_FACTOR / 4)
    assert verdict(run) == "off-prediction"


@pytest.mark.long
def test_three_times_the_quasi_static_factor_is_loose(monkeypatch):
    monkeypatch.setattr(soft_contact, QUASI_STATIC, soft_contact.QUASI_STATIC_FACTOR * 3)
    assert all(looseness(run)["body_angle"] > LOOSE["turn"] for run in TURNS)
    assert looseness(LINE)["displacement"] > LOOSE["displacement"]


@pytest.mark.parametrize("run", [LINE, OFF_CENTROID])
def test_a_sixth_of_the_overshoot_factor_is_refuted(run, monkeypatch):
    monkeypatch.setattr(soft_contact, OVERSHOOT, soft_contact.OVERSHOOT_FACTOR / 6)
    assert verdict(run) == "off-prediction"


@pytest.mark.parametrize("run", [LINE, OFF_CENTROID])
def test_ten_times_the_overshoot_factor_is_loose(run, monkeypatch):
    monkeypatch.setattr(soft_contact, OVERSHOOT, soft_contact.OVERSHOOT_FACTOR * 10)
    found = looseness(run)
    assert all(found[name] > LOOSE["loads"] for name in LOADS)
