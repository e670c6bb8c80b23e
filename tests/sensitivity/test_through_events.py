"""Derivatives from event to event against Richardson's differences of whole motions at fixed times,
and formulas of motions in which all supports stop together."""

from itertools import pairwise

import numpy as np
import pytest

from plumbob.analytic.sensitivities.capsule import phased_motion
from plumbob.models.gradient import exact_gradient
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.derivatives import scaled

# of a parameter: the longest, each halved
STEPS = (1e-2, 2e-3, 2e-4, 1e-6)
HALVINGS = 3
# Of scale: the usual error of these, and beside a switch that they step over; of derivatives.
USUAL, LARGEST, SURE = 2.2e-8, 1e-5, 1e-7
EVENTFUL = (
    ("capsule-coast/spin", ("friction", "inertia")),
    ("capsule-turn/pivot", ("friction", "radius")),
    ("capsule-turn/held", ("half_time", "angular_acceleration")),
    ("capsule-turn/0.1", ("body_mass", "gravity")),
)


def by_richardson(case, parameter, times, names):
    """Derivatives of the observables `names`, and their errors: what the last extrapolation changes
    and the motion's own uncertainty makes; the best of several, of those that pass no switch."""
    number = case.scene.parameters[parameter]
    unsure = phased_motion(case.problem).reference.uncertainty(times)
    doubt = np.array([unsure[name] for name in names])
    best = np.zeros(doubt.shape)
    errors = np.full(doubt.shape, np.inf)

    def phase(problem):
        return np.searchsorted(phased_motion(problem).switches, times, side="right")

    for longest in STEPS:
        row = []
        same = True
        for step in longest * abs(number) * 0.5 ** np.arange(HALVINGS + 1):
            ends = []
            for moved in (number - step, number + step):
                problem = case.system.problem({**case.scene.parameters, parameter: moved})
                same = same & (phase(problem) == phase(case.problem))
                observed = case.system.reference(problem).observe(times)
                ends.append(np.array([observed[name] for name in names]))
            row.append(np.diff(ends, axis=0)[0] / (2 * step))
        for order in range(1, HALVINGS + 1):
            before = row
            row = [b + (b - a) / (4**order - 1) for a, b in pairwise(before)]
        missed = np.where(same, np.abs(row[0] - before[1]) + 2 * doubt / step, np.inf)
        best, errors = np.where(missed < errors, (row[0], missed), (best, errors))
    return zip(names, best, errors, strict=True)


@pytest.mark.rare(keep=1)
@pytest.mark.long
@pytest.mark.parametrize(("name", "by"), EVENTFUL, ids=[name for name, _ in EVENTFUL])
def test_derivatives_through_events(name, by):
    """Slides, pivots, stops and slips, in the middle of each, near its ends, and at rest."""
    case = case_of(scene(name))
    switches = np.append(phased_motion(case.problem).switches, case.scene.duration)
    parts = np.array([0.1, 0.5, 0.9])[:, None]
    times = np.sort((switches[:-1] + parts * np.diff(switches)).ravel())
    found = exact_gradient(case, by, times)
    observed = case.reference.observe(times)
    for parameter in by:
        for of, wanted, errors in by_richardson(
            case, parameter, times, list(found[parameter].values)
        ):
            values = found[parameter].values[of]
            unsure = found[parameter].uncertainty[of]
            scale = scaled(values, observed[of], case.scene.parameters[parameter])
            off = np.abs(values - wanted) / (unsure + errors)
            assert (off <= 1.0).all(), (parameter, of, off)
            assert np.median(errors) <= USUAL * scale, (parameter, of, errors / scale)
            assert max(errors.max() * SURE / LARGEST, unsure.max()) <= SURE * scale, (
                parameter,
                of,
            )


@pytest.mark.long(keep=0)
@pytest.mark.parametrize("by", ["to", "friction"])
def test_a_plan_reaches_its_goal_for_all_parameters_near(by):
    """The final pose of a plan, made anew for each parameter, has the goal as its derivative: on
    the way the manoeuvres change with it, at every event."""
    case = case_of(scene("capsule-plan/beside-curve-12"))
    times = np.array([0.4, 1.0]) * case.scene.duration
    found = exact_gradient(case, [by], times, ["x", "y", "heading"])
    for name, one in found.items():
        for index, (observable, values) in enumerate(one.values.items()):
            wanted = float(name == f"to[{index}]")
            assert abs(values[1] - wanted) <= one.uncertainty[observable][1] + 1e-12
            assert one.uncertainty[observable].max() <= LARGEST
    assert (
        max(abs(values[0]) for one in found.values() for values in one.values.values()) > 1e-4
    )


@pytest.mark.parametrize(
    ("case", "observable", "speed", "power"),
    [("translation", "x", "velocity_x", 0.0), ("rotation", "heading", "heading_rate", 2.0)],
)
def test_all_supports_stop_together(case, observable, speed, power):
    """Where a motion has a formula its derivatives through the rest are those of the formula: x =
    v_x |v|/(2 f g), and a turn is proportional to the square of its rate."""
    coast = case_of(scene(f"capsule-coast/{case}"))
    p = coast.scene.parameters
    end = np.array([coast.scene.duration])
    derivatives = exact_gradient(coast, ["friction", "gravity", speed], end, [observable])
    way = float(coast.reference.observe(end)[observable][0])
    vx = p["velocity_x"]
    vy = p["velocity_y"]
    powers = {"friction": -1, "gravity": -1, speed: power or 1 + vx**2 / (vx**2 + vy**2)}
    for name, of in powers.items():
        slope = derivatives[name].values[observable][0]
        assert slope == pytest.approx(of * way / p[name], rel=1e-12)
