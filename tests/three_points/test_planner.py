"""The planner: poses reached, limits observed, time compared with simple plans, sensitivity."""

import itertools
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from plumbob.analytic.systems.capsule import Capsule, lowest_normal_forces
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import closed_form
from plumbob.analytic.systems.planner.construction import plan
from plumbob.analytic.systems.planner.lines import line_time
from plumbob.analytic.systems.planner.manoeuvre import slow_arc, slow_line
from plumbob.analytic.systems.planner.problem import GOAL_POSES, PlanLimits, RestPose
from plumbob.analytic.systems.planner.result import pose_error
from plumbob.analytic.systems.planner.tracks import Track, curved_track
from plumbob.analytic.systems.slider_path import ArcPiece, StraightPiece, arc, straight
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.models.registry import scene
from plumbob.models.tripod_capsule.plan import NEAR_GOAL, problem
from plumbob.reports.commands.plan import plan_record
from plumbob.tests.support.random_capsules import CHECK

PLACES = dict(GOAL_POSES)
CASES = tuple(itertools.product(PLACES, ("free", "curve")))
# In the full profile only: longer ways of the same mechanisms, and lines between other supports.
LATER = (
    ("aside", "free"),
    ("aside", "curve"),
    ("behind", "free"),
    ("behind", "curve"),
    ("half-turn", "curve"),
)
LATER_PAIRS = (((1, 2), "longer"), ((3, 1), "longer"))
# The plan is exact: the errors of the reference remain, 1e-13 over a hundred segments.
REACHED = 1e-11
# A scalene triangle, without symmetry about C-A1.
SCALENE = Capsule(1.3, 0.4, 0.03, ((0.22, 0.03), (-0.09, 0.17), (-0.12, -0.14)), 0.25, 9.81)


@pytest.fixture(name="quick")
def _quick(pytestconfig):
    return bool(pytestconfig.getoption("profile") == "quick")


@pytest.fixture(autouse=True)
def _of_the_profile(request, quick):
    """Skip a case of the full profile in the quick one."""
    given = request.node.callspec.params if hasattr(request.node, "callspec") else {}
    later = (given.get("name"), given.get("track", "curve")) in LATER
    later |= "case" not in given and (given.get("legs"), given.get("arc")) in LATER_PAIRS
    if quick and (later or given.get("profile") == "full"):
        pytest.skip("in the full profile")


@cache
def planned(name, track):
    """One of the suite's plans, made once in a process, with those that its scene is run with."""
    made = problem(scene(f"capsule-plan/{name}-{track}").parameters).motion
    assert (made.capsule, made.goal, made.track) == (CHECK, PLACES[name], track)
    assert made.limits == PlanLimits()
    return made


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(("name", "track"), CASES)
def test_every_pose_is_reached_at_rest_within_the_limits(name, track):
    made = planned(name, track)
    limits = PlanLimits()
    assert max(made.error) <= REACHED
    assert made.path.end == pytest.approx(made.goal.slider, abs=1e-12)
    assert made.motion.rest_time <= made.duration
    assert made.duration <= scene(f"capsule-plan/{name}-{track}").duration < made.duration + 0.2
    assert made.turns + made.lines <= limits.manoeuvres
    assert (made.turns > 0) == (abs(PLACES[name].heading) > 0.0)
    assert lowest_normal_forces(CHECK, made.path.track())[0].min() > 0.0
    for one in made.manoeuvres:
        for piece in one.path.pieces:
            # |w| is constant on a line and largest where the speed is on a circle.
            strength = np.linalg.norm(
                piece.kinematics(np.array([0.0, piece.duration]))[2], axis=1
            )
            assert strength.max() <= limits.acceleration * (1.0 + 1e-12)
        if one.kind == "turn":
            given = one.parameters
            way = given["radius"] * given["angular_acceleration"] * given["half_time"] ** 2
            assert given["radius"] == limits.radius
            assert abs(way) <= limits.stroke * (1.0 + 1e-12)
        if one.kind == "line":
            given = one.parameters
            stroke = closed_form(CHECK, given["w1"], given["w2"], given["t1"]).stroke
            assert stroke <= limits.stroke * (1.0 + 1e-12)
            assert track == "free" or stroke <= limits.radius * (1.0 + 1e-12)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(("name", "track"), CASES)
def test_the_body_rests_between_manoeuvres_and_in_slow_ones(name, track):
    made = planned(name, track)
    kinds = np.array([one.kind for one in made.manoeuvres])
    resting = kinds != "wait"
    slow = kinds == "slow"
    before = made.motion.at(np.array([one.start for one in made.manoeuvres]))
    after = made.motion.at(made.ends)
    # A start is rounded by several ulp of the duration, and the body then accelerates at some 1e3
    # rad/s^2 or m/s^2.
    still = 5e3 * np.spacing(made.duration)
    for change in (
        before.velocity[resting],
        before.angular_velocity[resting],
        (after.position - before.position)[slow],
        (after.heading - before.heading)[slow],
    ):
        assert np.abs(change).max() <= still


def parts_of_curve(made, place):
    """For each `place` of the slider, complex, without the track's own words: whether it is on the
    first line (0), the circle (1) or the second line (2), and the direction of the curve there."""
    ends = [complex(*made.capsule.supports[i - 1]) for i in made.legs]
    lines = [end / abs(end) for end in ends]
    radius = made.limits.radius
    assert np.abs(place).max() <= radius * (1 + 1e-12)
    on_circle = np.abs(np.abs(place) - radius) <= 1e-12
    on_line = [
        (np.abs((place / line).imag) <= 1e-12) & ((place / line).real >= -1e-12)
        for line in lines
    ]
    assert (on_circle | on_line[0] | on_line[1]).all()
    part = np.where(on_circle, 1, np.where(on_line[0], 0, 2))
    return part, np.select([part == 0, part == 1], [lines[0], 1j * place / radius], lines[1])


@pytest.mark.long
@pytest.mark.parametrize("name", PLACES)
def test_the_curve_has_one_degree_of_freedom(name):
    made = planned(name, "curve")
    times = np.linspace(0.0, made.duration, 4001)
    place, velocity = (xy @ [1.0, 1.0j] for xy in made.path.kinematics(times)[:2])
    part, direction = parts_of_curve(made, place)
    assert np.abs((velocity / direction).imag).max() <= 1e-11
    # The lines are joined by the arc only, though both lead to C.
    away = part[np.abs(place) > 1e-3]
    assert np.abs(np.diff(away)).max() <= 1


PAIRS = tuple(itertools.product(((1, 2), (2, 3), (3, 1)), ("shorter", "longer")))


@cache
def on_curve(legs, arc):
    """The plan of the scalene body along a pair of lines and an arc between them."""
    return plan(SCALENE, NEAR_GOAL, track="curve", legs=legs, arc=arc)


@pytest.mark.long
@pytest.mark.parametrize(("legs", "arc"), PAIRS)
def test_the_curve_may_have_any_two_lines_and_either_arc(legs, arc):
    made = on_curve(legs, arc)
    assert max(made.error) <= REACHED
    place = made.path.places(np.linspace(0.0, made.duration, 2001)) @ [1.0, 1.0j]
    part, _ = parts_of_curve(made, place)
    ends = [complex(*SCALENE.supports[i - 1]) for i in legs]
    on_circle = part == 1
    for line in (0, 2):  # both are gone along
        assert (np.abs(place)[part == line] > 0.1 * made.limits.radius).any()
    turned = np.abs(np.angle(place[on_circle] / ends[0]))
    between = abs(np.angle(ends[1] / ends[0]))
    way = np.angle(place[on_circle] / ends[0]) * np.sign(np.angle(ends[1] / ends[0]))
    inner = (way > 1e-6) & (turned < between - 1e-6)
    outer = (way < -1e-6) | (turned > between + 1e-6)
    assert (inner.any(), outer.any()) == ((True, False) if arc == "shorter" else (False, True))


@pytest.mark.parametrize("track", ["free", "curve"])
def test_lines_take_about_as_long_as_is_estimated(track):
    limits = PlanLimits()
    rails = Track(CHECK, limits) if track == "free" else curved_track(CHECK, limits)
    estimate = line_time(rails, PLACES["ahead"].place)
    assert estimate == pytest.approx(planned("ahead", track).duration, rel=0.05)


def quickened(path, factor):
    """The same path in less time: every acceleration times `factor`."""
    pieces = [p for p in path.pieces if isinstance(p, (ArcPiece, StraightPiece))]
    times = [p.duration / math.sqrt(factor) for p in pieces]
    rates = [factor * p.acceleration for p in pieces]
    first = pieces[0]
    if isinstance(first, ArcPiece):
        return arc(first.radius, first.angle, rates, times)
    return straight(first.origin, first.direction, rates, times)


@pytest.mark.parametrize("body", [CHECK, SCALENE])
def test_slow_motions_reach_the_friction_limit_and_no_more(body):
    a = 0.12
    for slow in (
        slow_line(body, 0j, a + 0j, 1.0),
        slow_line(body, a + 0j, a * complex(math.cos(1.0), math.sin(1.0)), 1.0),
        slow_arc(body, a, 0.3, 2.4, 1.0),
    ):
        assert three_point_motion(body, slow.path).events[0].mode == "rest"
        assert len(three_point_motion(body, slow.path).events) == 1
        assert len(three_point_motion(body, quickened(slow.path, 1.01)).events) > 1
    radial = slow_line(body, 0j, a + 0j, 0.9).parameters["acceleration"]
    assert radial == pytest.approx(0.9 * body.holding_acceleration, rel=1e-12)
    across = slow_arc(body, a, 0.3, 0.31, 1.0).parameters["angular_acceleration"] * a
    assert 0.7 < across / body.holding_acceleration < 0.9


@pytest.mark.parametrize("turns", [-3, 0, 1])
def test_headings_are_alike_up_to_whole_turns(turns):
    there = RestPose(1.0, 2.0, 3.0 + 2.0 * math.pi * turns)
    assert pose_error(there, RestPose(1.0, 2.0, 3.0)) == pytest.approx((0.0, 0.0), abs=1e-14)
    distance, angle = pose_error(there, RestPose(1.3, 1.6, -3.0))
    assert (distance, angle) == pytest.approx((0.5, 2.0 * math.pi - 6.0), abs=1e-14)


def test_what_is_said_of_a_plan_s_error():
    made = planned(next(iter(PLACES)), "free")
    elsewhere = RestPose(made.goal.x + 0.3, made.goal.y - 0.4, made.goal.heading + 0.1)
    said = plan_record(replace(made, goal=elsewhere))
    assert said["position_error"] == pytest.approx(0.5, abs=1e-9)
    assert said["heading_error"] == pytest.approx(0.1, abs=1e-9)
