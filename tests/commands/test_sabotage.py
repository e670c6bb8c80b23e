"""Sabotage of one thing at a time turns `validate` red, and the JUnit file with it."""

from dataclasses import replace
from functools import cache, partial
from types import MappingProxyType

import numpy as np
import pytest

from plumbob.engines import registry
from plumbob.engines.study import gradient, measurement
from plumbob.engines.study import stability as measuring
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses import requests
from plumbob.reports.judge import known_sizes
from plumbob.tests.commands.outcomes import (
    Changed,
    changed_runs,
    misread,
    validated,
    with_prepare,
    without_pages,
    without_theory,
)

PENDULUM, LINE = "simple-pendulum/free-small", "capsule-line/ca1"


@pytest.fixture
def validate(tmp_path, capsys, monkeypatch):
    """A `validate` of a scene and method."""
    without_pages(monkeypatch)
    return partial(validated, tmp_path, capsys)


SEARCH = measuring.StabilitySearch("linear-pendulum/overdamped", "ode/euler")
CONE, TURNING = "cone-pendulum/rotating-base", "simple-pendulum/damped-rotating"
FORCED, SLOW = "simple-pendulum/forced-large", "simple-pendulum/rotating-slow"


def red(found, scene, method):
    """Whether the exit code, the terminal and the JUnit file say so."""
    said = f"UNEXPECTED {scene} {method}: " in found.out
    counted = found.junit.attrib["failures"] == "1" and bool(found.failure(scene, method))
    assert (found.code == 1) == said == counted
    return said


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    ("scene", "method", "parameter", "factor"),
    [
        (CONE, "mujoco/euler", "platform_rate", 1.0 - 1e-4),
        (TURNING, "mujoco/euler", "damping_rate", 1.0 + 1e-3),
        (FORCED, "mujoco/euler", "gravity", 1.0 + 1e-4),
        (FORCED, "mujoco/rk4", "forcing_frequency", 1.0 + 1e-5),
        (SLOW, "mujoco/rk4", "gravity", 1.01),
        (SLOW, "mujoco/euler", "gravity", 1.01),
    ],
)
def test_a_parameter_that_is_read_wrongly(
    validate, monkeypatch, scene, method, parameter, factor
):
    assert parameter in find_scene(scene).parameters
    misread(monkeypatch, method.partition("/")[0], {parameter: factor})
    assert red(validate(scene, method), scene, method)


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("factor", [1.0, 2.5, 0.4])
def test_a_known_limit_that_grows_or_shrinks(validate, monkeypatch, factor):
    def scaled(case, run):
        exact = case.reference.observe(run.times)
        seen = {n: exact[n] + factor * (run.observables[n] - exact[n]) for n in run.observables}
        return replace(run, observables=seen)

    changed_runs(monkeypatch, "mujoco", scaled)
    assert red(validate(LINE, "mujoco/rk4"), LINE, "mujoco/rk4") == (factor != 1.0)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    ("scene", "method", "factor"),
    [
        ("capsule-line/heading-030", "mujoco/euler", 1.05),
        ("capsule-coast/translation", "mujoco/euler", 0.7),
        ("capsule-coast/translation", "mujoco/euler+pyramidal", 1.1),
    ],
)
def test_friction_that_is_read_wrongly_hides_in_no_known_limit(
    validate, monkeypatch, scene, method, factor
):
    misread(monkeypatch, "mujoco", {"friction": factor})
    found = validate(scene, method)
    assert red(found, scene, method)
    monkeypatch.setattr(known_sizes, "SAME_VERSIONS_FACTOR", known_sizes.FACTOR)
    assert not red(validate(scene, method), scene, method)


def test_a_method_that_loses_its_theory(validate, monkeypatch):
    """Its error still falls with the step; that no theory covers it is declared of nobody here."""
    without_theory(monkeypatch)
    found = validate(CONE, "mujoco/euler")
    assert red(found, CONE, "mujoco/euler")
    assert found.failure(CONE, "mujoco/euler").startswith("converges, expected predicted")


def added(run, size):
    """A run with a swing of this size [rad] added to its angle."""
    theta = run.observables["theta"] + size * np.sin(run.times)
    return replace(run, observables={**run.observables, "theta": theta})


def loose(prepare, case, method, tolerance):
    own = prepare(case, method, tolerance)
    return Changed(own, lambda run: added(run, 0.1)) if tolerance > 1e-9 else own


def relaxed(prepare, case, method, tolerance):
    return prepare(case, method, min(1e3 * tolerance, 0.5))


def right_where_listed(prepare, case, method, step):
    own = prepare(case, method, step)
    listed = (*case.scene.steps, *method.step_sizes, 1e-3, 2e-3)
    size = 0.0 if step in listed else 0.1
    return Changed(own, lambda run: added(run, size))


@pytest.mark.long(keep=4)
@pytest.mark.parametrize(
    ("broken", "method"),
    [
        *(
            (broken, f"ode/{name}")
            for broken in (loose, relaxed)
            for name in ("dop853", "lsoda")
        ),
        (relaxed, "ode/radau"),
        *((right_where_listed, m) for m in ("mujoco/euler", "ode/rk4", "ode/dop853")),
    ],
)
def test_a_solver_that_is_right_at_times(validate, monkeypatch, broken, method):
    """At small tolerances alone, by another tolerance than it is given, and at listed steps."""
    with_prepare(
        monkeypatch, method.partition("/")[0], lambda prepare: partial(broken, prepare)
    )
    assert red(validate(CONE, method), CONE, method)


def test_a_prediction_with_its_sign_flipped(validate, monkeypatch):
    held = measurement._held

    def flipped(predicted, *rest):
        return held(-predicted, *rest)

    monkeypatch.setattr(measurement, "_held", flipped)
    assert red(validate(CONE, "mujoco/euler"), CONE, "mujoco/euler")


@pytest.mark.long
def test_a_doctored_theory_of_the_largest_step(tmp_path, capsys, monkeypatch):
    """A tenth more than the theory says, where runs agree with it within 2 %."""
    monkeypatch.setattr(
        "plumbob.reports.analyses.requests", lambda plan, pairs_alone: (SEARCH,)
    )
    monkeypatch.setattr(
        "plumbob.reports.view.site.writing.write_study_pages",
        lambda study, out, *more: out / "none",
    )
    own = measuring.searched_limits
    found = {}

    def doctored(by, *given):
        limits = tuple(replace(limit, step=by * limit.step) for limit in given[3])
        return own(given[0], given[1], given[2], limits)

    for factor in (1.0, 1.1):
        monkeypatch.setattr(measuring, "searched_limits", partial(doctored, factor))
        folder = tmp_path / str(factor)
        found[factor] = validated(folder, capsys, SEARCH.scene, SEARCH.method)
    assert (found[1.0].code, found[1.1].code) == (0, 1)
    assert found[1.0].junit.attrib["failures"] == "0"
    assert "0 known limits, 0 unexpected" in found[1.0].out
    assert "0 known limits, 1 unexpected" in found[1.1].out
    assert f"UNEXPECTED {SEARCH.scene} {SEARCH.method}: largest step" in found[1.1].out
    assert found[1.1].failure(SEARCH.scene, f"{SEARCH.method}, largest step").startswith("0.9")


@cache
def _derivatives(search, made):
    return made(search, find_scene(search.scene), registry.method(search.method)).records


@pytest.mark.long
@pytest.mark.parametrize(
    ("factor", "off"), [(1.0 + 1e-4, 6), (1.0, 0), (-1.0, 6), (2.0, 6), (1.0 + 1e-5, 5)]
)
def test_a_doctored_derivative(validate, tmp_path, capsys, monkeypatch, factor, off):
    """By gravity and by the start, by three ways: another sign, a factor, and a ten-thousandth
    more. Every run is right. A hundred-thousandth more is within what the forward difference by
    the start leaves open, 1.6e-5 of the derivative: rounding of two ends over its eps of 3.7e-7."""
    own = gradient.GradientSearch.made

    def doctored(search, *_):
        def of(tried):
            return replace(tried, computed=factor * tried.computed)

        every = _derivatives(search, own)
        return gradient.Gradients(
            tuple(replace(one, tried=tuple(map(of, one.tried))) for one in every)
        )

    monkeypatch.setattr(gradient.GradientSearch, "made", doctored)
    outcome = validated(tmp_path, capsys, CONE, "ode/rk4", ["--gradients"])
    assert outcome.code == bool(off)
    assert outcome.junit.attrib["failures"] == str(off)
    assert f"0 known limits, {off} unexpected" in outcome.out
    if off:
        assert f"UNEXPECTED {CONE} ode/rk4: central, theta by gravity, " in outcome.out
        assert "from its prediction" in outcome.failure(
            CONE, "ode/rk4, central, theta by gravity"
        )


def test_nothing_is_red_without_sabotage(validate):
    assert not red(validate(CONE, "mujoco/euler"), CONE, "mujoco/euler")


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    ("scene", "method", "observable"),
    [
        (PENDULUM, "mujoco/rk4", "tension"),
        (LINE, "mujoco/euler", "normal_force_2"),
        ("cone-pendulum/rotating-base", "mujoco/euler", "theta_dot"),
    ],
)
def test_an_observable_that_an_engine_drops(validate, monkeypatch, scene, method, observable):
    def drop(case, run):
        kept = {name: seen for name, seen in run.observables.items() if name != observable}
        return replace(run, observables=kept)

    changed_runs(monkeypatch, method.partition("/")[0], drop)
    found = validate(scene, method)
    assert red(found, scene, method)
    assert found.failure(scene, method).endswith(f"the run leaves out {observable}")


def _until(run, last):
    """The first samples of a run."""
    named = {n: values[:last] for n, values in run.observables.items()}
    channels = {n: values[:last] for n, values in run.channels.items()}
    return replace(run, times=run.times[:last], observables=named, channels=channels)


def _wrong(run, channels):
    """A run of which observables are 1 % too large, with other channels."""
    return replace(
        run, observables={n: 1.01 * v for n, v in run.observables.items()}, channels=channels
    )


SABOTAGES = MappingProxyType(
    {
        "stops at a tenth": lambda run: _until(run, max(2, len(run.times) // 10)),
        "stops at once": lambda run: _until(run, 1),
        "channels that are no numbers": lambda run: replace(
            run, channels={n: np.full_like(v, np.nan) for n, v in run.channels.items()}
        ),
        "errors, and no channels": lambda run: _wrong(run, {}),
    }
)


@pytest.mark.long
@pytest.mark.parametrize("kind", SABOTAGES)
def test_findings_survive_what_an_engine_returns(kind, tmp_path, capsys, monkeypatch):
    """A verdict says it, and there is a page, with the findings on other engines."""
    # A study of chosen scenes leaves out findings that need other runs.
    all_requests = partial(requests, pairs_alone=False)
    monkeypatch.setattr(
        "plumbob.reports.analyses.requests", lambda plan, pairs_alone: all_requests(plan)
    )
    changed_runs(monkeypatch, "mujoco", lambda case, run: SABOTAGES[kind](run))
    found = validated(tmp_path, capsys, LINE, "mujoco/euler,mujoco/euler+coulomb,pymunk/feet")
    assert found.code == 1
    assert any(found.failure(LINE, name) for name in ("mujoco/euler", "mujoco/euler+coulomb"))
    assert found.failure(LINE, "pymunk/feet") == ""
    pages = "".join(p.read_text("utf-8") for p in (tmp_path / "out").rglob("*.html"))
    assert 'id="capsule-any-line"' in pages
    said = "left out, because the runs that they need" in pages
    assert said == (kind == "errors, and no channels")
