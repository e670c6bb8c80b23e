"""Derivatives from event to event against differences of whole motions at fixed times, and formulas
of motions in which all supports stop together."""

import numpy as np
import pytest

from plumbob.models.gradient import exact_gradient
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.derivatives import scaled

STEP, DIFFERENCES = 2e-5, 1e-6  # of a parameter, and of scale: the error of differences by it
SURE = 1e-7  # of scale
EVENTFUL = (
    ("capsule-coast/spin", ("friction", "velocity_x", "heading_rate", "inertia", "slider_mass")),
    ("capsule-turn/pivot", ("friction", "radius", "half_time", "start", "inertia")),
    ("capsule-turn/held", ("friction", "radius", "half_time", "angular_acceleration")),
    ("capsule-turn/0.1", ("friction", "radius", "body_mass", "start", "gravity")),
)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(("name", "by"), EVENTFUL, ids=[name for name, _ in EVENTFUL])
def test_derivatives_through_events(name, by):
    """Slides, pivots, stops and slips, in the middle of each, near its ends, and at rest."""
    case = case_of(scene(name))
    begins = [event.time for event in case.problem.motion.single.events]
    switches = np.array([*begins, case.scene.duration])
    parts = np.array([0.1, 0.5, 0.9])[:, None]
    times = np.sort((switches[:-1] + parts * np.diff(switches)).ravel())
    found, observed = exact_gradient(case, by, times), case.reference.observe(times)
    for parameter in by:
        number = case.scene.parameters[parameter]
        step = STEP * (abs(number) or 1.0)
        moved = ({**case.scene.parameters, parameter: number + side * step} for side in (1, -1))
        more, less = (case.system.reference(case.system.problem(p)).observe(times) for p in moved)
        for observable, values in found[parameter].values.items():
            scale = scaled(values, observed[observable], number)
            off = np.abs(values - (more[observable] - less[observable]) / (2.0 * step)).max()
            unsure = found[parameter].uncertainty[observable].max()
            assert off <= DIFFERENCES * scale, (parameter, observable, off / scale)
            assert unsure <= SURE * scale, (parameter, observable, unsure / scale)


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
            assert one.uncertainty[observable].max() <= DIFFERENCES
    assert max(abs(values[0]) for one in found.values() for values in one.values.values()) > 1e-4


@pytest.mark.parametrize(
    ("case", "observable", "speed", "power"),
    [("translation", "x", "velocity_x", 0.0), ("rotation", "heading", "heading_rate", 2.0)],
)
def test_all_supports_stop_together(case, observable, speed, power):
    """Where a motion has a formula its derivatives through the rest are those of the formula: x =
    v_x |v|/(2 f g), and a turn is proportional to the square of its rate."""
    coast = case_of(scene(f"capsule-coast/{case}"))
    p, end = coast.scene.parameters, np.array([coast.scene.duration])
    derivatives = exact_gradient(coast, ["friction", "gravity", speed], end, [observable])
    way = float(coast.reference.observe(end)[observable][0])
    vx, vy = p["velocity_x"], p["velocity_y"]
    powers = {"friction": -1, "gravity": -1, speed: power or 1 + vx**2 / (vx**2 + vy**2)}
    for name, of in powers.items():
        slope = derivatives[name].values[observable][0]
        assert slope == pytest.approx(of * way / p[name], rel=1e-12)
