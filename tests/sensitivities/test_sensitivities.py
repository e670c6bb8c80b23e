"""Exact derivatives against 60-digit differences, formulas, symmetries, and differences of motions
from event to event; and that a saltation with a term left out is noticed."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.sensitivities import sliding_motion
from plumbob.analytic.sensitivities.capsule import phased
from plumbob.analytic.sensitivities.neighbours import CENTRAL, Neighbours, Sensitivity
from plumbob.analytic.sensitivities.phases import phased_gradients
from plumbob.models.gradient import exact_gradient
from plumbob.models.registry import case_of, scene, systems
from plumbob.models.scene import Case
from plumbob.tests.sensitivities.recorded import FILE, nested, scene_of

SMOOTH, EVENTS = 1e-9, 1e-7  # of scale: what is asked of smooth motions, and of those with events
RECORDED = json.loads(FILE.read_text("utf-8"))
mpmath.mp.dps = 40


def scaled(case: Case, name: str, values: Array, observed: Array, number: float) -> float:
    """The scale of a derivative: its own size, or the observable's over the parameter's."""
    largest = max(float(np.abs(values).max()), float(np.abs(observed).max() / (abs(number) or 1)))
    return largest or 1.0


def agrees(found: Sensitivity, name: str, exact: Array, scale: float, within: float) -> str:
    """Why a derivative is not the exact one, within its uncertainty and within the accuracy asked
    for; empty where it is."""
    off, unsure = np.abs(found.values[name] - exact), found.uncertainty[name]
    if not (off <= unsure + 1e-16 * scale).all():
        return f"{name} off by {off.max()} of {scale}, uncertainty {unsure}"
    if not (off <= within * scale).all() or not (unsure <= within * scale).all():
        return f"{name} off by {off.max()}, uncertainty {unsure.max()}, of {scale}"
    return ""


@pytest.mark.parametrize("record", RECORDED, ids=lambda r: r["system"])
def test_recorded_derivatives(record: Mapping[str, Any]) -> None:
    """Pendulums, the free body, and a body sliding before its first stop, by every parameter at
    three random sets of them."""
    case = case_of(scene(scene_of(record["system"]), nested(record["parameters"])))
    times = np.array(record["times"])
    found = exact_gradient(case, list(record["by"]), times)
    observed = case.reference.observe(times)
    for name, exact in record["by"].items():
        for observable, text in exact.items():
            values = np.array(text, dtype=float)
            number = record["parameters"][name]
            scale = scaled(case, name, values, observed[observable], number)
            wrong = agrees(found[name], observable, values, scale, SMOOTH)
            assert not wrong, (name, wrong)


def line_in_40_digits(p: Mapping[str, Any], time: Any) -> dict[str, Any]:
    """Displacement, velocity, stroke and forces along a line, eqs. 11-14 of Chernousko 2020,
    integrated phase by phase."""
    total = p["body_mass"] + p["slider_mass"]
    mu, limit = p["slider_mass"] / total, p["friction"] * p["gravity"]
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
        x, v = x + v * span + a * span**2 / 2, v + a * span
        xi, rate = xi + rate * span + w * span**2 / 2, rate + w * span
        now += span
    if time >= stop:
        w, sliding = mpmath.mpf(0), 0
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


def _loads(p: Mapping[str, Any], reach: Any) -> dict[str, Any]:
    """Normal forces with the slider at `reach` along its line."""
    arms = p["supports"]
    along = p["slider_mass"] * p["gravity"] * reach
    total = (p["body_mass"] + p["slider_mass"]) * p["gravity"]
    moments = [along * mpmath.cos(p["direction"]), along * mpmath.sin(p["direction"])]
    matrix = mpmath.matrix([[1, 1, 1], [a[0] for a in arms], [a[1] for a in arms]])
    loads = mpmath.lu_solve(matrix, mpmath.matrix([total, *moments]))
    return {f"normal_force_{i}": load for i, load in enumerate(loads, start=1)}


def _exactly(parameters: Mapping[str, Any]) -> dict[str, Any]:
    def exact(value: Any) -> Any:
        return [exact(v) for v in value] if isinstance(value, tuple) else mpmath.mpf(value)

    return {name: exact(value) for name, value in parameters.items()}


def _nudged(p: Mapping[str, Any], name: str, step: Any) -> dict[str, Any]:
    head, *indices = name.replace("]", "").split("[")
    changed = {**p, "supports": [list(arm) for arm in p["supports"]]}
    if indices:
        changed[head][int(indices[0])][int(indices[1])] += step
    else:
        changed[head] += step
    return changed


def drawn_line(number: int) -> dict[str, Any]:
    """A random line manoeuvre, not along the axis of a support."""
    rng = np.random.default_rng(number)
    parameters = dict(scene("capsule-line").parameters)
    parameters.pop("support")
    for name in ("body_mass", "slider_mass", "friction", "gravity", "w1", "w2", "t1"):
        parameters[name] *= float(rng.uniform(0.9, 1.1))
    start, direction, heading = (float(v) for v in rng.uniform(-0.02, 2.0, 3))
    return {**parameters, "start": start / 100, "direction": direction, "heading": heading}


@pytest.mark.parametrize("number", range(3))
def test_line_derivatives(number: int) -> None:
    """A line manoeuvre by every parameter, in each of its phases, against 40 digits."""
    parameters = drawn_line(number)
    case = case_of(replace(scene("capsule-line"), parameters=parameters))
    switches = phased(case.problem).switches
    times = np.concatenate([(switches[1:] + switches[:-1]) / 2, [switches[-1] * 1.1]])
    by = [name for name in parameters if name not in ("inertia", "heading")]
    found = exact_gradient(case, [*by, "inertia", "heading"], times)
    exact, observed = _exactly(parameters), case.reference.observe(times)
    step = mpmath.mpf(10) ** -14
    for name, answer in found.items():
        if name in ("inertia", "heading"):
            assert (answer.values["heading"] == (name == "heading")).all()
            assert all((answer.values[o] == 0).all() for o in answer.values if o != "heading")
            continue
        ends = [
            [line_in_40_digits(_nudged(exact, name, s * step), mpmath.mpf(t)) for t in times]
            for s in (1, -1)
        ]
        for observable in ends[0][0]:
            pairs = zip(*ends, strict=True)
            values = [float((a[observable] - b[observable]) / (2 * step)) for a, b in pairs]
            number_here = 1.0 if "[" in name else parameters[name]
            scale = scaled(case, name, np.array(values), observed[observable], number_here)
            wrong = agrees(answer, observable, np.array(values), scale, SMOOTH)
            assert not wrong, (name, wrong)


def through_events(
    case: Case, names: Sequence[str], step: float = 3e-4
) -> tuple[Array, dict[str, Sensitivity]]:
    """Times in every phase of a motion from event to event, near the ends of each too, and its
    derivatives by differences of whole motions at the same part of each phase."""
    switches = np.append(phased(case.problem).switches, case.scene.duration)
    low, high = switches[:-1], switches[1:]
    times = np.unique(np.concatenate([low + part * (high - low) for part in (0.1, 0.5, 0.9)]))
    found = {}
    for name in names:
        number = case.scene.parameters[name]
        values = [number + k * step * (abs(number) or 1.0) for k in CENTRAL]
        changes = ({**case.scene.parameters, name: value} for value in values)
        problems = tuple(case.system.problem(changed) for changed in changes)
        beside = Neighbours(problems, np.array(values) - number)
        found[name] = phased_gradients([beside.each(phased)], times)[0]
    return times, found


EVENTFUL = (
    ("capsule-coast/spin", ("friction", "velocity_x", "heading_rate", "inertia", "slider_mass")),
    ("capsule-turn/pivot", ("friction", "radius", "half_time", "start", "inertia")),
    ("capsule-turn/held", ("friction", "radius", "half_time", "angular_acceleration")),
    ("capsule-turn/0.1", ("friction", "radius", "body_mass", "start", "gravity")),
)


def differing(case: Case, names: Sequence[str]) -> list[str]:
    """What differs from the differences of whole motions by more than these are uncertain."""
    times, differences = through_events(case, names)
    found, observed = exact_gradient(case, names, times), case.reference.observe(times)
    wrong = []
    for name, other in differences.items():
        for observable, values in found[name].values.items():
            number = case.scene.parameters[name]
            scale = scaled(case, name, values, observed[observable], number)
            off = np.abs(values - other.values[observable])
            unsure = found[name].uncertainty[observable]
            allowed = EVENTS * scale + 4 * other.uncertainty[observable]
            if not (off <= allowed).all() or not (unsure <= EVENTS * scale).all():
                wrong.append(f"{name} {observable} {off.max() / scale} {unsure.max() / scale}")
    return wrong


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(("name", "by"), EVENTFUL, ids=[name for name, _ in EVENTFUL])
def test_derivatives_through_events(name: str, by: tuple[str, ...]) -> None:
    """Slides, pivots, stops and slips, with saltation at each, in all phases."""
    assert not differing(case_of(scene(name)), by)


SABOTAGE = ("before", "after", "delay of a stop", "delay of a piece")


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("term", SABOTAGE)
def test_saltation_needs_every_term(term: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """F-, F+, and the time of an event by a stop and by the slider's path: each left out is seen."""
    nothing = np.zeros(6)
    if term == "before":
        monkeypatch.setattr(sliding_motion, "_before", lambda *_: nothing + 1e-30)
    elif term == "after":
        monkeypatch.setattr(sliding_motion, "_after", lambda *_: nothing)
    elif term == "delay of a stop":
        still = np.zeros(2)
        monkeypatch.setattr(sliding_motion, "_stop_delays", lambda *_: still)
    else:
        path = sliding_motion._delays

        def kept(before: Any, after: Any, columns: Array, *rest: Any) -> Array:
            if before.segment.piece != after.segment.piece:
                return np.zeros(columns.shape[1])
            return path(before, after, columns, *rest)

        monkeypatch.setattr(sliding_motion, "_delays", kept)
    wrong = differing(case_of(scene("capsule-turn/pivot")), ("half_time",))
    assert wrong


@pytest.mark.parametrize("name", ["capsule-coast/translation", "capsule-coast/rotation"])
def test_all_supports_stop_together(name: str) -> None:
    """Where a motion has a formula its derivatives through the rest are those of the formula."""
    case = case_of(scene(name))
    speed = "heading_rate" if name.endswith("rotation") else "velocity_x"
    observable = "heading" if name.endswith("rotation") else "x"
    end = np.array([case.scene.duration])
    found = exact_gradient(case, ["friction", "gravity", speed], end, [observable])
    way = float(case.reference.observe(end)[observable][0])
    for parameter in ("friction", "gravity"):
        slope = -way / case.scene.parameters[parameter]
        assert found[parameter].values[observable][0] == pytest.approx(slope, rel=1e-12)
    vx, vy = (case.scene.parameters[n] for n in ("velocity_x", "velocity_y"))
    # x = v_x |v|/(2 f g), the turn is proportional to the square of the rate.
    part = 2.0 if speed == "heading_rate" else 1.0 + vx**2 / (vx**2 + vy**2)
    slope = part * way / case.scene.parameters[speed]
    assert found[speed].values[observable][0] == pytest.approx(slope, rel=1e-12)


# Of observables and parameters: powers of a unit of mass, length and time.
UNITS = {
    "m": (0, 1, 0),
    "m/s": (0, 1, -1),
    "rad": (0, 0, 0),
    "rad/s": (0, 0, -1),
    "N": (1, 1, -2),
    "1": (0, 0, 0),
}
SIZES = {
    "body_mass": (1, 0, 0),
    "slider_mass": (1, 0, 0),
    "mass": (1, 0, 0),
    "inertia": (1, 2, 0),
    "inertia_x": (1, 2, 0),
    "inertia_y": (1, 2, 0),
    "inertia_z": (1, 2, 0),
    "density": (1, -3, 0),
    "gravity": (0, 1, -2),
    "w1": (0, 1, -2),
    "w2": (0, 1, -2),
    "t1": (0, 0, 1),
    "pause": (0, 0, 1),
    "half_time": (0, 0, 1),
    "angular_acceleration": (0, 0, -2),
    "radius": (0, 1, 0),
    "supports": (0, 1, 0),
    "slider": (0, 1, 0),
    "length": (0, 1, 0),
    "height": (0, 1, 0),
    "pivot_x": (0, 1, 0),
    "pivot_y": (0, 1, 0),
    "velocity_x": (0, 1, -1),
    "velocity_y": (0, 1, -1),
    "theta_dot": (0, 0, -1),
    "platform_rate": (0, 0, -1),
    "heading_rate": (0, 0, -1),
    "angular_velocity": (0, 0, -1),
    "damping_rate": (0, 0, -1),
    "forcing_frequency": (0, 0, -1),
    "forcing_amplitude": (0, 0, -2),
}
METAMORPHIC = (
    "cone-pendulum/rotating-base",
    "simple-pendulum/rotating-slow",
    "linear-pendulum/free-large",
    "free-body/flip",
    "capsule-line/at-50",
    "capsule-train/ten",
    "capsule-hold/slow-motion",
    "capsule-coast/spin",
    "capsule-turn/0.3",
)


@pytest.mark.long(keep=7)
@pytest.mark.parametrize("axis", range(3), ids=("mass", "length", "time"))
@pytest.mark.parametrize("name", METAMORPHIC)
def test_derivatives_obey_units(name: str, axis: int) -> None:
    """A motion is the same in another unit of mass, length or time: the parameters' derivatives
    and the velocity add up to the observable itself (Euler's theorem)."""
    case = case_of(scene(name))
    parameters = case.scene.parameters
    by = [n for n in SIZES if n in parameters and SIZES[n][axis]]
    if name == "free-body/flip" and axis == 1:
        pytest.skip("lengths and masses are in the moments of inertia only")
    times = np.array([0.31, 0.83]) * case.scene.duration
    edge = 1e-5 * case.scene.duration
    found = exact_gradient(case, by, times)
    observed = case.reference.observe(times)
    around = [case.reference.observe(times + k * edge) for k in (-2, -1, 1, 2)]
    for observable in case.system.observables:
        total = np.zeros(2)
        for key, one in found.items():
            value: Any = parameters[key.partition("[")[0]]
            for index in key.replace("]", "").split("[")[1:]:
                value = value[int(index)]
            power = SIZES[key.partition("[")[0]][axis]
            total += power * value * one.values[observable.name]
        if axis == 2:
            a, b, c, d = (part[observable.name] for part in around)
            total += times * (a - 8 * b + 8 * c - d) / (12 * edge)
        wanted = UNITS[observable.unit][axis] * observed[observable.name]
        size = max(float(np.abs(total).max()), float(np.abs(wanted).max()), 1e-3)
        assert np.abs(total - wanted).max() <= 1e-6 * size, (observable.name, total, wanted)


def test_mirrored_capsules_have_mirrored_derivatives() -> None:
    """A body, its slider and its start reflected across x: derivatives by y-like parameters of
    y-like observables agree, mixed ones change their sign."""
    case = case_of(scene("capsule-coast/spin", {"slider": (0.05, 0.03)}))
    given = dict(case.scene.parameters)
    (a, b, c), (x, y) = given["supports"], given["slider"]
    mirrored = {
        "supports": tuple((px, -py) for px, py in (a, b, c)),
        "slider": (x, -y),
        "velocity_y": -given["velocity_y"],
        "heading_rate": -given["heading_rate"],
    }
    other = case_of(scene("capsule-coast/spin", {**given, **mirrored}))
    odd = ("y", "velocity_y", "heading", "heading_rate", "slider[1]")
    by, times = ["friction", "velocity_x", "velocity_y", "heading_rate", "slider"], np.array([0.35])
    one, two = (exact_gradient(each, by, times) for each in (case, other))
    for parameter, found in one.items():
        for observable, values in found.values.items():
            sign = -1.0 if (parameter in odd) != (observable in odd) else 1.0
            same = two[parameter].values[observable]
            assert values == pytest.approx(sign * same, rel=1e-9, abs=1e-11)


def test_the_known_derivative() -> None:
    """The final displacement of the line at 30 degrees by the friction coefficient."""
    case = case_of(scene("capsule-line/heading-030"))
    found = exact_gradient(case, ["friction"], np.array([0.15]), ["displacement"])["friction"]
    assert found.values["displacement"][0] == pytest.approx(0.0196745, abs=5e-9)


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
def test_where_there_is_no_derivative(name: str, parameter: str, side: str, reason: str) -> None:
    """A reason, and the one-sided derivative where it exists."""
    case = case_of(scene(name))
    times = np.array([case.scene.duration])
    found = exact_gradient(case, [parameter], times)[parameter]
    assert reason in found.why
    assert all(np.isnan(values).all() for values in found.values.values())
    for each, values in (("below", found.below), ("above", found.above)):
        exists = all(np.isfinite(v).all() for v in values.values())
        assert exists == (each == side)


def test_a_switch_of_plan_has_no_derivative() -> None:
    """Another sequence of manoeuvres is another motion."""
    system = systems()["capsule-plan"]
    near, half = (case_of(scene(f"capsule-plan/{c}-free")).problem for c in ("near", "half-turn"))
    assert system.structure(near) != system.structure(half)


def test_derivatives_exist_on_a_separatrix() -> None:
    """The closed form has none, but at finite times the equations do: by the angular velocity, on
    the separatrix and 1e-9 off it they are nearly the same, and grow."""
    times = np.array([1.0, 3.0])
    on, off = (
        exact_gradient(case_of(scene(f"free-body/{c}")), ["inertia_x", "angular_velocity"], times)
        for c in ("separatrix", "separatrix-1e-9")
    )
    for name, found in on.items():
        for observable, values in found.values.items():
            assert values == pytest.approx(off[name].values[observable], rel=1e-5, abs=1e-5)
    growth = on["angular_velocity[0]"].values["angular_velocity_x"]
    assert abs(growth[1]) > 5 * abs(growth[0])


@pytest.mark.parametrize(
    ("by", "shown"),
    [
        ("freedom", "freedom"),
        ("supports[3]", "supports[3]"),
        ("excess", "excess"),
        ("theta[0]", "theta[0]"),
    ],
)
def test_refused_parameters(by: str, shown: str) -> None:
    """A parameter that is unknown, or that the case leaves out."""
    name = "capsule-line" if by.startswith("supports") else "cone-pendulum"
    case = case_of(scene(name))
    with pytest.raises(ParameterError) as refused:
        exact_gradient(case, [by], np.array([0.1]))
    assert shown in str(refused.value)


def test_left_out_parameters_have_derivatives() -> None:
    """The heading that a scene leaves out is 0; a cone has the moments that its shape gives."""
    line = case_of(scene("capsule-line/ca1"))
    found = exact_gradient(line, ["heading"], np.array([0.1]), ["heading"])
    assert found["heading"].values["heading"][0] == 1.0
    cone = case_of(scene("cone-pendulum"))
    shape = exact_gradient(cone, ["density"], np.array([0.4]))["density"]
    body = exact_gradient(
        cone, ["mass", "inertia_x", "inertia_y", "inertia_z", "inertia_yz"], np.array([0.4])
    )
    moments = cone.problem.body
    names = ("mass", "inertia_x", "inertia_y", "inertia_z")
    through = (
        sum(getattr(moments, n) * body[n].values["theta"][0] for n in names)
        / cone.scene.parameters["density"]
    )
    size = moments.mass * abs(body["mass"].values["theta"][0])
    assert abs(through - shape.values["theta"][0]) <= 1e-9 * size
    assert math.isfinite(body["inertia_yz"].values["theta"][0])
