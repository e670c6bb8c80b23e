"""Engines that are wrong and hide it: the heading is left out, or the model-error bound is wide."""

from dataclasses import replace

import pytest

from plumbob.engines.registry import engine_of, engines, installed, methods
from plumbob.engines.registry import method as find_method
from plumbob.engines.study import measurement
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.measurement import measure
from plumbob.engines.study.runner import most_steps, pairs
from plumbob.models.registry import case_of, scenes, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.expectations import run_surprise, surprise
from plumbob.reports.judge.not_read import not_read
from plumbob.reports.judge.tolerance import STARTS_OFF, TOO_WIDE
from plumbob.reports.judge.verdict import judge
from plumbob.reports.judge.verdict import judge_method as judged_of

TURNED = (
    *(s for s in scenes("capsule-*/heading-*") if s.name.endswith(("030", "345"))),
    find_scene("capsule-hold/0.999", {"heading": -2.0}),
    find_scene("capsule-coast/spin", {"heading": -2.0}),
    find_scene("capsule-coast/translation", {"heading": -2.0}),
    find_scene("capsule-train/ten", {"heading": 9.0}),
)
ENGINES = tuple(  # MuJoCo, whose methods are most, last
    name
    for name, engine in reversed(list(engines().items()))
    if installed(engine) and engine.methods and pairs(TURNED, methods(name))
)
HIDDEN = (  # where a bound that is 10,000 times as wide hides a hundredth of friction
    ("capsule-coast/spin", "mujoco/euler+coulomb"),
    ("capsule-turn/0.3", "pymunk/feet"),
    ("capsule-turn/heading-030", "pymunk/feet"),
    ("capsule-train/ten", "mujoco/rk4+coulomb"),
)


def changing(monkeypatch, change, wider=1.0):
    """Have every engine build and read another case, and declare bounds so many times as wide."""

    def false(method):
        true = engine_of(method)

        def bounds(case, method, step):
            found = true.model_error(case, method, step)
            return {
                name: {why: wider * bound for why, bound in by_reason.items()}
                for name, by_reason in found.items()
            }

        return replace(
            true,
            prepare=lambda case, method, step: true.prepare(change(case), method, step),
            model_error=bounds,
        )

    monkeypatch.setattr(measurement, "engine_of", false)


def without_heading(case):
    setup = replace(case.problem.setup, heading=0.0)
    return replace(case, problem=replace(case.problem, setup=setup))


def with_more_friction(case):
    capsule = case.problem.setup.capsule
    setup = replace(
        case.problem.setup, capsule=replace(capsule, friction=1.01 * capsule.friction)
    )
    return replace(case, problem=replace(case.problem, setup=setup))


def study(scene, method):
    return convergence_study(scene, method, most_steps(scene, "quick"))


def judged(scene, method, found):
    about = system_of(scene).quantities(case_of(scene))
    return judged_of(found, system_of(scene), method, about).whole


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("engine", ENGINES)
def test_no_engine_leaves_the_heading_out(engine, monkeypatch):
    """Each run of a scene that is turned is unexpected where the engine's body is not, known limits
    too, though all but the heading is as in the scene that is not turned."""
    changing(monkeypatch, without_heading)
    for scene, method, verdict in _runs(engine):
        assert verdict.reason.startswith(f"{STARTS_OFF}: heading"), (scene.name, method.name)
        assert run_surprise(scene, method, verdict), (scene.name, method.name)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("engine", ENGINES)
def test_every_engine_turns_its_body(engine):
    for scene, method, verdict in _runs(engine):
        assert not verdict.reason.startswith(STARTS_OFF), (
            scene.name,
            method.name,
            verdict.reason,
        )


def _runs(engine):
    """The verdicts on a run of each turned scene, with the methods that give a heading of it."""
    for scene, method in pairs(TURNED, methods(engine)):
        steps = method.step_sizes if method.control == "tolerance" else scene.steps
        found, _ = measure(case_of(scene), method, steps[0])
        if found.status != "unsupported" and "heading" not in not_read(scene.name, method.name):
            yield scene, method, judge(found, system_of(scene), method)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(("scene", "method"), HIDDEN)
def test_a_wide_bound_hides_no_friction(scene, method, monkeypatch):
    changing(monkeypatch, with_more_friction, 1e4)
    where = find_scene(scene)
    how = find_method(method)
    verdict = judged(where, how, study(where, how))
    assert verdict.reason.startswith(TOO_WIDE)
    assert surprise(where, how, verdict)
