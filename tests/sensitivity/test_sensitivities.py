"""Exact derivatives against differences of 40 and 60 digits, and where there are none."""

import json
from dataclasses import replace
from pathlib import Path

import mpmath
import numpy as np
import pytest

from plumbob.analytic.sensitivities.capsule import phased_motion
from plumbob.models.gradient import exact_gradient
from plumbob.models.registry import case_of, scene, systems
from plumbob.tests.support.derivatives import scaled
from plumbob.tests.support.extrapolation import tuples

SMOOTH, EVENTS = 1e-9, 1e-7  # of scale
KNOWN = 3e-8  # likewise: the error of poses with smoothed friction
RECORDED = json.loads(Path(__file__).with_name("recorded.json").read_text("utf-8"))
# Where a record takes seconds, `make test-long` alone has the second and third of a system.
SLOW = ("four-bar", "n-pendulum", "capsule-plan")
mpmath.mp.dps = 40


def agrees(found, name, exact, scale, within, known=1e-16):
    """Why a derivative is not the exact one, `known` to a part of its scale, within its uncertainty
    and within the accuracy asked for; empty where it is."""
    off = np.abs(found.values[name] - exact)
    unsure = found.uncertainty[name]
    if not (off <= unsure + known * scale).all():
        return f"{name} off by {off.max()} of {scale}, uncertainty {unsure}"
    if not (off <= within * scale).all() or not (unsure <= within * scale).all():
        return f"{name} off by {off.max()}, uncertainty {unsure.max()}, of {scale}"
    return ""


def _cases():
    """The recorded derivatives as cases of a test."""
    systems_before = []
    for record in RECORDED:
        system = record["scene"].partition("/")[0]
        again = system in SLOW and system in systems_before
        systems_before.append(system)
        marks = pytest.mark.rare if again else ()
        yield pytest.param(record, id=record["scene"], marks=marks)


@pytest.mark.long(keep=7)
@pytest.mark.parametrize("record", [*_cases()])
def test_recorded_derivatives(record):
    """Smooth motions, by every parameter at three random sets of them; turns, coasts and plans
    through their stops and pivots, and at rest."""
    case = case_of(scene(record["scene"], tuples(record["parameters"])))
    times = np.array(record["times"])
    found = exact_gradient(case, list(record["by"]), times)
    observed = case.reference.observe(times)
    for name, exact in record["by"].items():
        for observable, text in exact.items():
            values = np.array(text, dtype=float)
            number = record["numbers"][name]
            scale = scaled(values, observed[observable], number)
            accuracy = (EVENTS, KNOWN) if "/" in record["scene"] else (SMOOTH,)
            wrong = agrees(found[name], observable, values, scale, *accuracy)
            assert not wrong, (name, wrong)


def line_in_40_digits(p, time):
    """Displacement, velocity, stroke and forces along a line, eqs. 11-14 of Chernousko 2020,
    integrated phase by phase."""
    total = p["body_mass"] + p["slider_mass"]
    mu = p["slider_mass"] / total
    limit = p["friction"] * p["gravity"]
    rest = p["t1"] * mu * (p["w1"] + p["w2"]) / (mu * p["w2"] + limit)
    stop = p["t1"] * (p["w1"] + p["w2"]) / p["w2"]
    x = v = xi = rate = now = w = mpmath.mpf(0)
    sliding = 0
    for end, push, slides in ((p["t1"], p["w1"], 1), (rest, -p["w2"], 1), (stop, -p["w2"], 0)):
        span = min(end, time) - now
        if span <= 0:
            break
        w, sliding = push, slides
        a = (limit - mu * w) * sliding
        x = x + v * span + a * span**2 / 2
        v = v + a * span
        xi = xi + rate * span + w * span**2 / 2
        rate = rate + w * span
        now += span
    if time >= stop:
        w = mpmath.mpf(0)
        sliding = 0
    friction = total * limit if sliding else p["slider_mass"] * w
    driving = p["slider_mass"] * (w + (friction - p["slider_mass"] * w) / total)
    return {
        "displacement": x,
        "velocity": v,
        "stroke": xi,
        "stroke_rate": rate,
        "friction_force": friction,
        "driving_force": driving,
    } | _loads(p, p["start"] + xi)


def _loads(p, reach):
    """Normal forces with the slider at `reach` along its line."""
    arms = p["supports"]
    along = p["slider_mass"] * p["gravity"] * reach
    total = (p["body_mass"] + p["slider_mass"]) * p["gravity"]
    moments = [along * mpmath.cos(p["direction"]), along * mpmath.sin(p["direction"])]
    matrix = mpmath.matrix([[1, 1, 1], [a[0] for a in arms], [a[1] for a in arms]])
    loads = mpmath.lu_solve(matrix, mpmath.matrix([total, *moments]))
    return {f"normal_force_{i}": load for i, load in enumerate(loads, start=1)}


def _exactly(parameters):
    def exact(value):
        return [exact(v) for v in value] if isinstance(value, tuple) else mpmath.mpf(value)

    return {name: exact(value) for name, value in parameters.items()}


def _nudged(p, name, step):
    head, *indices = name.replace("]", "").split("[")
    changed = {**p, "supports": [list(arm) for arm in p["supports"]]}
    if indices:
        changed[head][int(indices[0])][int(indices[1])] += step
    else:
        changed[head] += step
    return changed


def drawn_line(number):
    """A random line manoeuvre, not along the axis of a support."""
    rng = np.random.default_rng(number)
    parameters = dict(scene("capsule-line").parameters)
    parameters.pop("support")
    for name in ("body_mass", "slider_mass", "friction", "gravity", "w1", "w2", "t1"):
        parameters[name] *= float(rng.uniform(0.9, 1.1))
    start, direction, heading = (float(v) for v in rng.uniform(-0.02, 2.0, 3))
    return {**parameters, "start": start / 100, "direction": direction, "heading": heading}


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("number", range(3))
def test_line_derivatives(number):
    """A line manoeuvre by every parameter, in each of its phases, against 40 digits."""
    parameters = drawn_line(number)
    case = case_of(replace(scene("capsule-line"), parameters=parameters))
    switches = phased_motion(case.problem).switches
    times = np.concatenate([(switches[1:] + switches[:-1]) / 2, [switches[-1] * 1.1]])
    by = [name for name in parameters if name not in ("inertia", "heading")]
    found = exact_gradient(case, [*by, "inertia", "heading"], times)
    exact = _exactly(parameters)
    observed = case.reference.observe(times)
    step = mpmath.mpf(10) ** -14
    for name, answer in found.items():
        if name in ("inertia", "heading"):
            for observable, values in answer.values.items():
                turned = name == observable == "heading"
                assert values == pytest.approx(float(turned), abs=1e-10)
            continue
        ends = [
            [line_in_40_digits(_nudged(exact, name, s * step), mpmath.mpf(t)) for t in times]
            for s in (1, -1)
        ]
        for observable in ends[0][0]:
            pairs = zip(*ends, strict=True)
            slopes = [float((a[observable] - b[observable]) / (2 * step)) for a, b in pairs]
            values = np.array(slopes)
            number_here = 1.0 if "[" in name else parameters[name]
            scale = scaled(values, observed[observable], number_here)
            wrong = agrees(answer, observable, values, scale, SMOOTH)
            assert not wrong, (name, wrong)


@pytest.mark.parametrize(
    ("name", "parameter", "side", "reason"),
    [
        ("simple-pendulum/free-large", "damping_rate", "above", "must be 0 or greater"),
        ("capsule-line/w2-threshold", "w2", "below", "must be at most f g/mu"),
        ("capsule-line/w2-threshold", "friction", "above", "must be at most f g/mu"),
        ("capsule-line/frictionless", "friction", "", "must be 0 or greater; w2 ="),
        ("capsule-line/ca1", "support", "", "must be 1, 2 or 3"),
        ("capsule-train/ten", "count", "", "must be a whole number"),
    ],
)
def test_where_there_is_no_derivative(name, parameter, side, reason):
    """A reason, and the one-sided derivative where it exists."""
    case = case_of(scene(name))
    times = np.array([case.scene.duration])
    found = exact_gradient(case, [parameter], times)[parameter]
    assert reason in found.why
    assert all(np.isnan(values).all() for values in found.values.values())
    for each, values in (("below", found.below), ("above", found.above)):
        exists = all(np.isfinite(v).all() for v in values.values())
        assert exists == (each == side)


def test_derivatives_exist_on_a_separatrix():
    """The closed form has none, but at finite times the equations do: by the angular velocity, on
    the separatrix and 1e-9 off it they are nearly the same, and grow."""
    times = np.array([1.0, 3.0])
    on, off = (
        exact_gradient(
            case_of(scene(f"free-body/{c}")), ["inertia_x", "angular_velocity"], times
        )
        for c in ("separatrix", "separatrix-1e-9")
    )
    for name, found in on.items():
        for observable, values in found.values.items():
            assert values == pytest.approx(off[name].values[observable], rel=1e-5, abs=1e-5)
    growth = on["angular_velocity[0]"].values["angular_velocity_x"]
    assert abs(growth[1]) > 5 * abs(growth[0])


@pytest.mark.long
def test_a_switch_of_plan_has_no_derivative():
    """Another sequence of manoeuvres is another motion."""
    cases = (case_of(scene(f"capsule-plan/{name}-free")) for name in ("near", "half-turn"))
    near, half = (systems()["capsule-plan"].structure(case.problem) for case in cases)
    assert near != half
