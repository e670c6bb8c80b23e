"""Small mistakes fail the verdict, in every system and for every kind of exact answer: a run passes
when it is held to its own scene, and fails when one parameter of that is a little different."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import pytest

from plumbob.engines.method import meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene
from plumbob.reports.judge.verdict import judge
from plumbob.tests.support.cases import run_of
from plumbob.tests.support.mujoco_capsule import FINE, GOOD, REDUCED
from plumbob.tests.support.random_capsules import CHECK
from plumbob.tests.support.random_slides import moved_support

SWING, TURN = "simple-pendulum/free-large", "cone-pendulum/rotating-base"
SLOW, TOP = "simple-pendulum/rotating-slow", "simple-pendulum/near-top-1e-6"
DAMPED, BARRIER = "simple-pendulum/damped-rotating", "cone-pendulum/above-barrier-1e-6"
LINE, CIRCLE, SPIN = "capsule-line/ca1", "capsule-turn/0.3", "capsule-coast/spin"
MOVED = moved_support(CHECK, 1e-4).supports
SWAPPED = tuple(CHECK.supports[i] for i in (0, 2, 1))


def fixed_steps(name, *orders):
    """The methods with fixed steps of these orders that are meant for a scene."""
    return " ".join(
        method.name
        for method in find_methods("*")
        if method.control == "step"
        and method.order in orders
        and meant(method, scene(name))
        and not engine_of(method).optional
    )


def of(engine, *names):
    """Methods of an engine."""
    return " ".join(f"{engine}/{name}" for name in names)


@dataclass(frozen=True)
class Wrong:
    """Scenes run with methods at a step [s] (above 1: in parts of the half time), or at the
    smallest tolerance; and the relative changes of parameters, or other values of them."""

    scenes: str
    methods: str
    step: float
    changes: Mapping[str, Any]
    duration: float = 0.0  # [s] if not the scene's
    stepped: bool = False  # at a step that no series reaches


MILLIONTH = {"length": 1e-6, "damping_rate": 1e-6}
RATES = {"gravity": 1e-6, "platform_rate": 1e-6, "pivot_y": 1e-6, "theta_dot": 1e-6}
LINES = {"friction": 1e-4, "slider_mass": 1e-4, "w1": 1e-4}
FORCED = {"gravity": 1e-3, "length": 1e-3, "forcing_amplitude": 1e-3, "damping_rate": 1e-3}
EDGE = ("capsule-coast/edge", of("mujoco", "euler+coulomb", "rk4+coulomb"), 2e-4)
HEAVY = ("capsule-turn/heavy-slider", of("mujoco", "euler+coulomb", "rk4+coulomb"), 200)
# Exact answers by Jacobi functions, Taylor series and closed forms; the error of RK4 is 1e-9 to
# 1e-6 rad, that of a parameter wrong by a millionth ten times as large.
WRONG = (
    Wrong(
        "simple-pendulum/free-small simple-pendulum/free-large simple-pendulum/damped-small "
        "simple-pendulum/forced-large linear-pendulum/free-large linear-pendulum/damped-large "
        "linear-pendulum/forced-large",
        "ode/rk4",
        5e-3,
        MILLIONTH,
        20.0,
    ),
    Wrong(f"{SLOW} {DAMPED}", "ode/rk4", 2e-3, MILLIONTH, 20.0),
    Wrong("simple-pendulum/forced-chaotic", "ode/rk4", 1e-2, MILLIONTH, 20.0),
    Wrong(
        "simple-pendulum/damped-large",
        "mujoco/rk4",
        5e-3,
        {**MILLIONTH, "gravity": 1e-6, "theta": 1e-6},
    ),
    Wrong(
        "linear-pendulum/forced-large",
        "pymunk/spring",
        1e-3,
        {"length": 1e-2, "damping_rate": 1e-2, "forcing_amplitude": 1e-2},
        20.0,
    ),
    Wrong("simple-pendulum/forced-large", "pymunk/default", 1e-4, FORCED, 5.0),
    Wrong("simple-pendulum/forced-large", "pymunk/tight", 2e-4, FORCED, 5.0),
    Wrong(TURN, "mujoco/rk4 ode/rk4", 5e-4, RATES),
    Wrong(TURN, "mujoco/rk4", 1e-4, RATES),
    Wrong(TURN, "ode/dop853", 1e-13, RATES),
    # the source prints I_x for I_y: equal for a cone, wrong for a general body
    Wrong("cone-pendulum/unequal-inertia", "mujoco/rk4", 5e-4, {"inertia_y": -0.0325}),
    Wrong(
        " ".join(
            f"cone-pendulum/{name}"
            for name in (
                "rotating-base",
                "resting-base",
                "unequal-inertia",
                "product-of-inertia",
                "deep-well",
            )
        ),
        "pymunk/torque",
        1e-4,
        {"gravity": 1e-2},
    ),
    Wrong(SWING, of("ode", "dop853", "lsoda") + " heyoka/taylor", 0.0, {"gravity": 1e-9}),
    Wrong(SWING, "ode/radau", 0.0, {"gravity": 1e-6}),
    Wrong(
        TURN, of("ode", "dop853", "radau", "lsoda") + " heyoka/taylor", 0.0, {"platform_rate": 1e-6}
    ),
    Wrong(SLOW, fixed_steps(SLOW, 1, 2, 4), 1e-1, {"gravity": 1e-2}, 0.0, True),
    Wrong(SLOW, fixed_steps(SLOW, 1, 2), 5e-2, {"gravity": 1e-2}, 0.0, True),
    Wrong(TOP, fixed_steps(TOP, 1, 2), 2e-2, {"gravity": 1e-2}),
    Wrong(TOP, fixed_steps(TOP, 4), 0.2, {"gravity": 1e-2}),
    Wrong(SLOW, "mujoco/euler", 1e-2, {"gravity": 1e-9}, 0.0, True),
    Wrong(SLOW, "ode/leapfrog", 2e-2, {"gravity": 1e-9}, 0.0, True),
    Wrong(SLOW, "ode/rk4", 1e-1, {"gravity": 1e-9}, 0.0, True),
    Wrong(SLOW, "pymunk/tight", 5e-3, {"gravity": 1e-8}, 0.0, True),  # of larger round-off
    Wrong(BARRIER, "mujoco/euler", 1e-3, {"gravity": 1e-8}, 0.0, True),
    Wrong(BARRIER, "ode/euler", 1e-3, {"platform_rate": 1e-9}, 0.0, True),
    Wrong(DAMPED, "mujoco/euler ode/euler", 2e-2, {"damping_rate": 1e-6}, 0.0, True),
    Wrong(DAMPED, "pymunk/default", 1e-2, {"damping_rate": 1e-6}, 0.0, True),
    Wrong(LINE, of("mujoco", *FINE), 1e-3, {**LINES, "gravity": 1e-4}),
    Wrong("capsule-line/at-50", "pymunk/feet pymunk/side", 1e-3, LINES),
    Wrong("capsule-line/at-123", of("mujoco", *GOOD), 1e-3, {"supports": SWAPPED}),
    Wrong(LINE, of("mujoco", *REDUCED), 1e-3, {"friction": 1e-7}),
    Wrong(LINE, of("mujoco", *REDUCED), 1e-3, {"friction": -1e-7}),
    Wrong(LINE, of("mujoco", *REDUCED), 1e-4, {"friction": 1e-8}),
    Wrong(LINE, of("mujoco", *REDUCED), 1e-4, {"friction": -1e-8}),
    Wrong(
        CIRCLE,
        "mujoco/rk4+coulomb",
        800,
        {"friction": 1e-4, "supports": MOVED, "slider_mass": 1e-5},
    ),
    Wrong(CIRCLE, "pymunk/feet", 400, {"friction": 1e-4, "supports": MOVED}),
    Wrong(SPIN, "pymunk/feet", 5e-4, {"friction": 1e-4, "supports": MOVED}),
    Wrong(*EDGE, {"friction": 1e-2, "gravity": 1e-4}),
    Wrong(*EDGE, {"friction": -1e-2, "gravity": -1e-4}),
    Wrong(*HEAVY, {"friction": 1e-2}),
    Wrong(*HEAVY, {"friction": -1e-2}),
    Wrong(HEAVY[0], "mujoco/euler+coulomb", 1600, {"gravity": 1e-4}),
    Wrong(HEAVY[0], "mujoco/euler+coulomb", 1600, {"gravity": -1e-4}),
)


def rows(wrong):
    """Each scene, method and parameter, but for parameters that are zero."""
    for name in wrong.scenes.split():
        for method in wrong.methods.split():
            for parameter, change in wrong.changes.items():
                if value := scene(name).parameters[parameter]:
                    other = change if isinstance(change, tuple) else value * (1.0 + change)
                    yield name, method, parameter, other, wrong


# What the short suite runs comes first: the first row of each but MuJoCo's turns with their feet,
# which take longest.
NUMBERED = [(i, row) for wrong in WRONG for i, row in enumerate(rows(wrong))]
SLOW_ROWS = sum(wrong.step > 1.0 and "mujoco" in wrong.methods for wrong in WRONG)
ROWS = [
    row
    for _, row in sorted(
        NUMBERED, key=lambda pair: (pair[0] > 0, pair[1][4].step > 1.0 and "mujoco" in pair[1][1])
    )
]


def verdict(found, method):
    """The verdict on a run."""
    return judge(found, case_of(scene(found.scene)).system, method).verdict


@pytest.mark.long(keep=len(WRONG) - SLOW_ROWS)
@pytest.mark.parametrize(
    ("name", "method", "parameter", "value", "wrong"),
    ROWS,
    ids=["-".join(row[:3]) for row in ROWS],
)
def test_a_wrong_parameter(name, method, parameter, value, wrong):
    how, right, other = find_method(method), scene(name), scene(name, {parameter: value})
    if not installed(engine_of(how)):
        pytest.skip(f"{engine_of(how).package} is not installed: make peers")
    step = wrong.step or how.step_sizes[-1]
    step = step if step < 1.0 else right.parameters["half_time"] / step
    right, other = (
        replace(case, duration=wrong.duration or case.duration) for case in (right, other)
    )
    found, _ = run_of(how, right, step)
    if wrong.stepped:
        predicted = found.errors["theta"].predicted
        assert predicted
        assert predicted.uncertainty is not None
    assert verdict(found, how) == "predicted"
    assert verdict(run_of(how, right, step, other)[0], how) == "off-prediction"


@pytest.mark.parametrize(
    ("names", "methods", "step"),
    [
        (
            "cone-pendulum/rotating-base cone-pendulum/unequal-inertia cone-pendulum/deep-well",
            "mujoco/euler mujoco/rk4 ode/leapfrog ode/rk4",
            (2e-4, 2e-3),
        ),
        (LINE, "mujoco/euler+coulomb", (5e-4, 1e-3)),
    ],
)
def test_an_error_of_a_larger_step(names, methods, step):
    """Ten times, or twice, as large as the step at which it is said to be measured."""
    for case in (case_of(scene(name)) for name in names.split()):
        for how in map(find_method, methods.split()):
            right, large = (measure(case, how, h)[0] for h in step)
            pretended = {
                name: replace(error, largest=large.errors[name].largest)
                for name, error in right.errors.items()
            }
            assert verdict(right, how) == "predicted"
            assert verdict(replace(right, errors=pretended), how) == "off-prediction", (
                case.scene.name,
                how,
            )
