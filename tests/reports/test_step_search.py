"""The search for steps, on made-up errors: it finds the largest that holds, and runs few."""

from dataclasses import replace

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.method import Method
from plumbob.engines.study.measurement import Measurement, ObservedError
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Quantity, step_sizes
from plumbob.reports.advice.step_search import RESOLVED_RATIO, Evidence, cheapest_choices
from plumbob.tests.support.studies import SCENE

STEPS = step_sizes(5e-3, 1e-4)
SAWTOOTH = Method("made/sawtooth", Scheme(EULER), 1)
OTHER = replace(SAWTOOTH, name="made/other")
ONE = replace(find_scene(SCENE), name="made/one", duration=1.0)
TWO = replace(ONE, name="made/two")


def _measured(scene, method, step, error):
    found = {"x": ObservedError(error, error, 1e-16, 1.0)}
    return Measurement(
        scene.name,
        method.name,
        step,
        "done",
        errors=found,
        duration=scene.duration,
        steps=round(scene.duration / step),
    )


def evidence(
    error,
    scenes=(ONE,),
    methods=(SAWTOOTH,),
    ns=(1000.0, 1000.0),
):
    """What is known after convergence studies at STEPS."""

    def run(scene, method, step):
        return _measured(scene, method, step, error(scene.name, method.name, step))

    return Evidence(
        scenes,
        {s.name: (Quantity("x", 1.0),) for s in scenes},
        {
            (s.name, m.name): price
            for s in scenes
            for m, price in zip(methods, ns, strict=False)
        },
        {(s.name, m.name): {h: run(s, m, h) for h in STEPS} for s in scenes for m in methods},
        run,
        45.0,
    )


def best(found, wanted, *methods):
    chosen = cheapest_choices(found, methods or (SAWTOOTH,), wanted)
    return chosen[0] if chosen else None


@given(slope=st.sampled_from([1.0, 2.0, 4.0]), at=st.floats(-5.5, -1.0))
def test_a_smooth_error_is_reached_at_nearly_the_largest_step(slope, at):
    largest = 10.0**at
    found = evidence(lambda scene, method, h: 0.01 * (h / largest) ** slope)
    choice = best(found, 0.01)
    assert choice.step <= largest
    # Beyond a step that holds one more is tried, 1.8 times as large, up to an eighth of the scene.
    assert choice.step >= min(largest / RESOLVED_RATIO / 1.01, ONE.duration / 8 / 1.81)
    assert choice.error <= 0.01
    assert choice.absolute == found.scale * choice.error
    assert sum(map(len, found.runs.values())) <= 60 + len(STEPS)


@example(phase=0.03307573688860826, wanted=0.0013341420277954894)  # hardly a slope
@example(
    phase=0.03766863105557477, wanted=0.0001
)  # 1.86 times the wanted error, all of it lucky
@example(
    phase=0.0234375, wanted=0.0015712947727248346
)  # below many steps that fail by the margin
@given(phase=st.floats(0.02, 0.05), wanted=st.floats(1e-4, 3e-3))
def test_a_sawtooth_is_not_trusted_at_a_lucky_zero(phase, wanted):
    def error(scene, method, h):
        return h * ((phase / h) % 1.0)

    choice = best(evidence(error), wanted)
    # Every step below the wanted error is good, and those that are twice as large are not.
    assert wanted / 1.5 <= choice.step < 2.0 * wanted
    near = [error("", "", choice.step * part) for part in (1.0, 0.995, 0.98, 0.96, 0.92, 0.85)]
    assert max(near) < 2.0 * wanted


def test_the_worst_scene_of_a_family_decides():
    def error(scene, method, h):
        return h * (1.0 if scene == ONE.name else 3.0)

    alone, both = (best(evidence(error, scenes), 1e-3) for scenes in ((ONE,), (ONE, TWO)))
    assert alone.step == pytest.approx(1e-3, rel=0.1)
    assert both.step == pytest.approx(1e-3 / 3, rel=0.1)


def test_the_cheaper_method_between_the_steps_is_found():
    # By the steps that were run the other method is cheaper: 0.5 and 0.2 ms.
    def error(scene, method, h):
        return h * (2.01 if method == SAWTOOTH.name else 2.0)

    found = evidence(error, methods=(SAWTOOTH, OTHER), ns=(1000.0, 2000.0))
    choice = best(found, 1e-3, SAWTOOTH, OTHER)
    assert choice.method == SAWTOOTH.name
    assert choice.step > 4.4e-4


def test_an_error_that_crosses_zero_counts_as_the_largest_of_smaller_steps():
    """The signed error h - 1e-3 crosses zero at 1 ms, and is 5e-4 at half of that."""
    found = evidence(lambda scene, method, h: abs(h - 1e-3))
    errors = {choice.step: choice.error for choice in found.choices(SAWTOOTH)}
    assert errors[1e-3] == pytest.approx(1e-3 - min(STEPS))
    assert errors[5e-3] == pytest.approx(4e-3)
