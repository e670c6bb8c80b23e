"""ODE solvers on systems without an angle called theta: a falling body and a thrown one."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from plumbob.engines.adapters import heyoka
from plumbob.engines.adapters.ode import ENGINE, prepare
from plumbob.engines.adapters.ode.equation import Equation
from plumbob.engines.adapters.ode.integrators import integrator
from plumbob.engines.adapters.ode.simulation import (
    SOLVERS,
    AdaptiveSimulation,
    FixedStepSimulation,
)
from plumbob.engines.method import Unsupported, meant
from plumbob.engines.study.measurement import measure
from plumbob.models.scene import ONE_SMOOTH, Observable, Scene, System

FIXED = [method for method in ENGINE.methods if method.control == "step"]
ADAPTIVE = [method for method in ENGINE.methods if method.control == "tolerance"]
GRAVITY = 9.81  # [m/s^2]
TERMINAL = 7.0  # [m/s]
DRAG = 0.6  # [1/s]
LAUNCH = np.array([3.0, 5.0])  # [m/s]


class Exact:
    """What a problem's own answer says beside its state."""

    def uncertainty(self, times):
        """A few roundings of each."""
        return {n: 4 * 2.0**-52 * np.abs(v) for n, v in self.observe(times).items()}

    def observe(self, times):
        """The exact state; see the problems."""
        raise NotImplementedError

    def leading_error(self, scheme, times):
        """Theory has none."""
        return {}

    def nonlinearity(self, times, errors):
        """The fall stays linear for the errors here."""
        return 0.0


@dataclass(frozen=True)
class Fall(Exact):
    """A body that falls from rest under quadratic drag, to a terminal speed."""

    def observe(self, times):
        """Height [m] and its rate [m/s]: v = -u tanh(g t/u), y = -u^2/g ln cosh(g t/u)."""
        scaled = GRAVITY * times / TERMINAL
        height = -(TERMINAL**2) / GRAVITY * np.log(np.cosh(scaled))
        return {"height": height, "height_rate": -TERMINAL * np.tanh(scaled)}

    def equation(self):
        """y'' = -g + g (y'/u)^2 while it falls."""
        square = GRAVITY / TERMINAL**2

        def acceleration(time, height, rate):
            return square * rate * rate - GRAVITY

        return Equation(
            acceleration, 0.0, 0.0, TERMINAL, names=("height",), rate_names=("height_rate",)
        )


@dataclass(frozen=True)
class Throw(Exact):
    """A body thrown in a plane under linear drag: two coordinates."""

    declared: bool  # whether the equation declares its damping rate

    def observe(self, times):
        """x, z [m] and their rates [m/s]: v = v_t + (v_0 - v_t) e^(-k t), v_t = (0, -g/k)."""
        settled = np.array([0.0, -GRAVITY / DRAG])
        decay = np.exp(-DRAG * times)[:, None]
        rates = settled + (LAUNCH - settled) * decay
        places = settled * times[:, None] + (LAUNCH - settled) * (1.0 - decay) / DRAG
        names = ("x", "z", "velocity_x", "velocity_z")
        return dict(zip(names, [*places.T, *rates.T], strict=True))

    def equation(self):
        """r'' = -k r' + g."""
        weight = np.array([0.0, -GRAVITY])

        def acceleration(time, place, rate):
            return weight - DRAG * rate

        return Equation(
            acceleration,
            np.zeros(2),
            LAUNCH,
            speed=20.0,
            damping_rate=DRAG if self.declared else None,
            names=("x", "z"),
            rate_names=("velocity_x", "velocity_z"),
        )


PROBLEMS = (Fall(), Throw(declared=True), Throw(declared=False))


@pytest.fixture(params=PROBLEMS, ids=["fall", "throw", "throw-undeclared"])
def case(request, monkeypatch):
    """A scene of a system whose builder is a module of the adapter's, as CONTRIBUTING has it."""
    problem = request.param
    module = ModuleType("plumbob.engines.adapters.ode.falling_body")
    module.build = lambda problem, method: problem.equation()
    monkeypatch.setitem(sys.modules, module.__name__, module)
    system = System(
        name="falling-body",
        title="Falling body",
        observables=tuple(Observable(name, "SI") for name in problem.observe(np.zeros(1))),
        parameters=(),
        scenes=(),
        default="",
        problem=lambda parameters: problem,
        reference=lambda problem: problem,
        invariants=lambda problem, observables: {},
        facts=lambda problem: {},
        mjcf=Path(),
        family="falling_body",
        kind=ONE_SMOOTH,
    )
    scene = Scene("falling-body/test", "", {}, 2.0, (), "elementary", kind=ONE_SMOOTH)
    return system.case(scene)


@pytest.mark.parametrize("method", FIXED, ids=lambda method: method.name)
def test_fixed_steps_converge_with_their_order(case, method):
    # two octaves of steps, at which the next term of the series is some per cent of the first
    assert method.order is not None
    steps = np.array([0.02, 0.01, 0.005])
    found = [measure(case, method, float(step))[0] for step in steps]
    assert {run.status for run in found} == {"done"}
    for name in case.reference.observe(np.zeros(1)):
        errors = [run.errors[name].largest for run in found]
        slope = float(np.polyfit(np.log(steps), np.log(errors), 1)[0])
        assert slope == pytest.approx(method.order, abs=0.12)


@pytest.mark.parametrize("method", ADAPTIVE, ids=lambda method: method.name)
def test_adaptive_solvers_follow_the_exact_motion(case, method):
    # the tolerance a step, grown over some tens to hundreds of steps
    found, trajectory = measure(case, method, 1e-7)
    assert set(trajectory.observables) == set(case.reference.observe(np.zeros(1)))
    for error in found.errors.values():
        assert 0.0 < error.largest < 3e-5


def test_a_declared_damping_rate_gives_the_same_leapfrog():
    # the implicit half kick is solved in closed form or by iteration, to the rounding of 200 steps
    leapfrog = next(method for method in FIXED if method.name == "ode/leapfrog")
    ends = [run_of(Throw(declared=declared), leapfrog, 0.01) for declared in (True, False)]
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-13)


def run_of(problem, method, step):
    """All observables at 2 s."""
    advance = integrator(method.scheme.integrator)
    run = FixedStepSimulation(problem.equation(), advance, round(2.0 / step), step, 0.0).run()
    return np.array([values[-1] for values in run.observables.values()])


def exploding(time, place, rate):
    """theta'' = 6 theta^2, whose solution 1/(1 - t)^2 from (1, 2) ends at t = 1."""
    return 6 * place * place


def sine_of_much(time, place, rate):
    """A force that overflows, for which math.sin then raises."""
    return math.sin(place) + 1e3 * place


DIVERGING = {
    "one": Equation(exploding, 1.0, 2.0, 10.0),
    "raises": Equation(sine_of_much, 1.0, 2.0, 10.0),
    # arrays overflow without an exception, and numpy's warnings about it are switched off
    "two": Equation(
        exploding, np.ones(2), 2 * np.ones(2), 10.0, names=("x", "z"), rate_names=("u", "w")
    ),
}


@pytest.mark.long(keep=6)
@pytest.mark.parametrize("kind", DIVERGING)
@pytest.mark.parametrize("method", ENGINE.methods, ids=lambda method: method.name)
def test_divergence_is_a_result(method, kind):
    equation = DIVERGING[kind]
    if method in FIXED:
        advance = integrator(method.scheme.integrator)
        simulation = FixedStepSimulation(equation, advance, 30_000, 1e-3, 0.0)
        assert kind != "raises" or simulation.stepped(1.0).steps == 0  # nothing to time
    else:
        solver = SOLVERS[method.settings["method"]]
        simulation = AdaptiveSimulation(equation, solver, 1e-6, 30.0, 0.0)
    trajectory = simulation.run()
    assert len(trajectory.times) > 1
    assert (trajectory.times < trajectory.diverged_at).all() or method in ADAPTIVE
    for values in trajectory.observables.values():
        assert len(values) == len(trajectory.times)
        assert np.isfinite(values).all()


def test_the_same_run_twice(case):
    # the start is copied: no run changes what the next one starts from
    simulation = prepare(case, FIXED[0], 0.01)
    first, second = simulation.run(), simulation.run()
    for name, values in first.observables.items():
        np.testing.assert_array_equal(values, second.observables[name])


def test_heyoka_refuses_what_is_no_rotor(case):
    with pytest.raises(Unsupported, match="heyoka has no builder for falling-body"):
        heyoka.prepare(case, heyoka.METHODS[0], 1e-9)


def test_ode_methods_are_meant_for_all_but_dry_friction(case):
    slide = Scene("capsule-line/ca1", "", {}, 1.0, (), "")
    for method in ENGINE.methods:
        assert meant(method, case.scene)
        assert not meant(method, slide)
