"""Bodies that friction holds: exact answers against 40 digits, drift and depths against theory."""

import math
import re
from dataclasses import replace

import mujoco
import numpy as np
import pymunk
import pytest
from mpmath import mp

from plumbob.analytic.errors.contact_models import soft_friction
from plumbob.analytic.errors.contact_models.held_bodies import corner, corners
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.schemes import SoftPoint
from plumbob.engines.abilities import SettingsToPaste
from plumbob.engines.adapters.mujoco import contacts, incline, pinch, stack
from plumbob.engines.adapters.mujoco.translation import set_contacts
from plumbob.engines.method import meant
from plumbob.engines.registry import engine_of, limits_of, method, methods
from plumbob.engines.study.measurement import measure, scheme_of
from plumbob.models.registry import case_of, matching_scenes, scene
from plumbob.reports.judge.verdict import judge

CUBE = case_of(scene("incline/stops")).problem
STACK = case_of(scene("stack/equal")).problem
BUILDERS = {"incline": incline, "pinch": pinch, "stack": stack}


def slid(cube, time):
    """Place and speed of a cube on a slope with 40 digits: what rests stays where Coulomb's
    friction holds it, and what stops begins anew."""
    g, f, slope, v = map(mp.mpf, (cube.gravity, cube.friction, cube.slope, cube.speed))
    x = mp.mpf(0)
    left = mp.mpf(float(time))
    while left > 0:
        pull, press = g * mp.sin(slope), g * mp.cos(slope)
        if v == 0 and pull <= f * press:
            break
        rate = pull - f * press * (mp.sign(v) or 1)
        lasts = min(left, -v / rate) if v * rate < 0 else left
        x, v = x + lasts * (v + lasts * rate / 2), v + lasts * rate
        v = mp.mpf(0) if lasts < left else v
        left -= lasts
    return x, v


@pytest.mark.parametrize("speed", [0.0, 1.0, -2.0])
@pytest.mark.parametrize("part", [0.0, 0.3, 0.999999, 1.0, 1.000001, 1.05, 2.5])
def test_incline_with_40_digits(speed, part):
    cube = replace(CUBE, slope=math.atan(part * CUBE.friction), speed=speed)
    stop = cube.stop_time if math.isfinite(cube.stop_time) else 1.0
    times = np.concatenate([np.linspace(0.0, 1.5 * stop + 1.0, 23), [stop, 1e-9]])
    exact = cube.observe(times)
    doubt = cube.uncertainty(times)
    with mp.workdps(40):
        for i, time in enumerate(times):
            x, v = slid(cube, time)
            assert abs(x - mp.mpf(exact["x"][i])) <= doubt["x"][i]
            assert abs(v - mp.mpf(exact["speed"][i])) <= doubt["speed"][i] + mp.eps
    assert doubt["speed"][-1] < 1e-14  # at the start


def least_push(body):
    """The force [N] of each finger that just holds a body against its weight and what pushes it,
    with 40 digits: half of the load each, by Coulomb's law."""
    down = mp.mpf(body.mass) * (mp.mpf(body.gravity) + mp.mpf(body.lift))
    return mp.hypot(down, mp.mpf(body.push)) / (2 * mp.mpf(body.friction))


@pytest.mark.parametrize("way", ["slip", "speed"])
@pytest.mark.parametrize(
    "changes", [{}, {"push": 3.0}, {"lift": 2.0}, {"push": -4.0, "lift": 5.0}]
)
def test_a_pinch_holds_what_its_friction_does_with_40_digits(changes, way):
    """And moves nothing; a billionth less is refused."""
    body = replace(case_of(scene("pinch/0.5")).problem, normal_force=1e3, **changes)
    with mp.workdps(40):
        least = float(least_push(body))
    held = replace(body, normal_force=least * (1 + 1e-9))
    assert held.fraction == pytest.approx(1 / (1 + 1e-9), rel=1e-15)
    assert not held.observe(np.linspace(0.0, 10.0, 11))[way].any()
    with pytest.raises(ParameterError, match="or the body slips"):
        replace(body, normal_force=least * (1 - 1e-9))


def chosen_runs():
    """Each scene with each method that a theory covers there, of the engines that are installed
    with plumbob."""
    own = [m for m in methods() if not engine_of(m).optional]
    pairs = [(s, m) for s in matching_scenes(",".join(BUILDERS)) for m in own if meant(m, s)]
    return [
        pytest.param(s, m, id=f"{s.name} {m.name}")
        for s, m in pairs
        if limits_of(m.name).limit(s.name, m.name) is None
    ]


@pytest.mark.long(keep=40)
@pytest.mark.parametrize(("chosen", "how"), chosen_runs())
def test_runs_are_predicted(chosen, how):
    """At steps that nobody listed, one of them longer than half a soft contact's time constant;
    what is predicted of a drift is right to a thousandth of it."""
    case = case_of(chosen)
    coarse = 3e-3 if "coulomb" in how.name else 1.3e-2
    for step in (coarse, 7e-4) if how.control == "step" else how.step_sizes[-1:]:
        found, _ = measure(case, how, step)
        judged = judge(found, case.system, how)
        assert judged.verdict == "predicted", judged.reason
        held = next(iter(found.errors.values()))
        if held.predicted and "solver" in held.model:
            assert held.predicted.difference < 1e-3 * held.largest + 1e-9 > 0.0


def settled(cone, ratio, part, heading):
    """A cube on default contacts but for their cone after 1 s, and what theory takes."""
    case = case_of(scene("incline/rest"))
    cube = replace(case.problem, slope=math.atan(part * CUBE.friction), heading=heading)
    built = incline.build(case.system.mjcf, cube, method("mujoco/euler"), 2e-3)
    spec = built.spec
    spec.option.cone = {"pyramidal": 0, "elliptic": 1}[cone]
    spec.option.timestep, spec.option.impratio, spec.option.tolerance = 2e-3, ratio, 1e-16
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = built.qpos  # from no depth, what is just held may chatter, and slide
    mujoco.mj_step(model, data, nstep=500)
    mujoco.mj_forward(model, data)
    return cube, model, data, SoftPoint(ratio=ratio, pyramidal=cone == "pyramidal")


@pytest.mark.parametrize("ratio", [1.0, 10.0, 100.0])
@pytest.mark.parametrize(
    ("part", "heading"), [(0.3, 0.0), (0.9, 0.0), (0.65, 0.5), (0.65, 2.0)]
)
@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
def test_drift_depth_and_softness(cone, ratio, part, heading):
    cube, _, data, point = settled(cone, ratio, part, heading)
    held = corner(cube)
    along = np.array([math.cos(heading), math.sin(heading)])
    down = data.qpos[2]
    across = np.array([-along[1], along[0]])
    drifted = held.drift(point, 2e-3)[0]
    measured = [along @ drifted, across @ drifted]
    np.testing.assert_allclose(data.qvel[:2], measured, 1e-5, 1e-7 * np.hypot(*drifted))
    assert -down == pytest.approx(held.depth(point, 2e-3), rel=1e-5)
    d = soft_friction.impedance(point, -down)
    soft = held.edge_softness(point) if point.pyramidal else 1.0 / ratio
    row = 0 if point.pyramidal else 1
    assert data.efc_R[row] == pytest.approx((1 - d) / d * soft * held.weight, rel=1e-6)


@pytest.mark.parametrize(
    ("friction", "part", "gravity"),
    [(0.9, 0.9, 100.0), (0.86, 0.65, 100.0), (0.9, 0.9, 9.81), (0.86, 0.501, 7.0)],
)
def test_normal_forces_that_settle_use_a_part_of_their_bound(friction, part, gravity):
    """A tenth to nine tenths: SETTLING is calibrated."""
    changes = {"friction": friction, "gravity": gravity, "slope": math.atan(part * friction)}
    chosen = scene("incline/rest")
    case = case_of(replace(chosen, parameters={**chosen.parameters, **changes}))
    found, _ = measure(case, method("mujoco/euler"), 1e-3)
    held = found.errors["x"]
    assert held.predicted
    assert 0.1 < held.predicted.difference / held.model["settling"] < 0.9


def pasted(name, friction):
    """Settings to paste for 1 ms."""
    asked = method(name)
    ability = engine_of(asked).ability(SettingsToPaste)
    assert ability
    return ability.write(asked, 1e-3, None, friction).snippets[0]


def allowed_by(name):
    """The number in what settings to paste promise."""
    number = re.search(r"([0-9.e-]+) s(\^2)? times", pasted(name, 0.8).error)
    assert number
    return float(number[1])


GRIPPER = """<mujoco><option timestep="1e-3" {options}/>
<default><geom type="box" friction="0.8"/></default><worldbody>
<body name="left" pos="-.05 0 0"><joint type="slide" axis="1 0 0" name="left"/>
  <geom size=".01 .015 .03" mass=".25"/></body>
<body name="right" pos=".05 0 0"><joint type="slide" axis="-1 0 0" name="right"/>
  <geom size=".01 .015 .03" mass=".25"/></body>
<body name="box"><freejoint/><geom size=".0399 .02 .045" mass=".35"/></body></worldbody>
<actuator><motor joint="left"/><motor joint="right"/></actuator></mujoco>"""


@pytest.mark.parametrize("ratio", ["100", "1e4"])
def test_the_drift_that_settings_promise_holds_in_another_gripper(ratio):
    """A free box between two box fingers, on eight contacts, at 0.9 of what friction holds."""
    bound = allowed_by("mujoco/euler+elliptic") * 100 / float(ratio)
    options = f'cone="elliptic" impratio="{ratio}"'
    model = mujoco.MjModel.from_xml_string(GRIPPER.format(options=options))
    data = mujoco.MjData(model)
    data.ctrl[:] = 0.35 * 9.81 / (2 * 0.8 * 0.9)
    model.opt.gravity[2] = 0.0
    mujoco.mj_step(model, data, nstep=600)
    model.opt.gravity[2] = -9.81
    mujoco.mj_step(model, data, nstep=400)
    before = data.body("box").xpos[2]
    mujoco.mj_step(model, data, nstep=1000)
    weights = model.body("box").invweight0[0] + model.body("left").invweight0[0]
    allowed = bound * 0.35 * 9.81 / 8 * weights
    assert data.ncon == 8
    assert 0.9 * allowed < before - data.body("box").xpos[2] < allowed


@pytest.mark.parametrize("mass_ratio", [1e-4, 0.3, 1.0, 50.0])
@pytest.mark.parametrize("name", ["mujoco/euler", "mujoco/euler+stiff"])
def test_forces_in_a_stack(name, mass_ratio):
    """Every corner carries a quarter of what is above it, and is as deep as theory says, where each
    mass and sum is taken with 40 digits."""
    held = replace(STACK, count=3, mass_ratio=mass_ratio)
    case = case_of(scene("stack/equal"))
    how = method(name)
    built = stack.build(case.system.mjcf, held, how, 1e-3)
    built.spec.option.timestep, built.spec.option.tolerance = 1e-3, 1e-20
    model = built.spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = built.qpos
    mujoco.mj_forward(model, data)
    with mp.workdps(40):
        masses = [held.mass * mp.mpf(mass_ratio) ** (mp.mpf(i) / 2) for i in range(3)]
        above = [mp.mpf(held.gravity) * sum(masses[i:]) for i in range(3)]
        np.testing.assert_allclose(held.normal_forces, [float(force) for force in above], 4e-16)
    point = scheme_of(case, how).contact
    assert point
    for contact, force in zip(data.contact, data.efc_force, strict=True):
        level = max(contact.geom) - 1
        assert force == pytest.approx(held.normal_forces[level] / 4, rel=1e-5)
        assert -contact.dist == pytest.approx(corners(held)[level].depth(point, 1e-3), rel=1e-7)
    np.testing.assert_allclose(data.qacc, 0.0, atol=1e-10)


def stacked(cubes):
    """Weights on the lower faces of cubes at rest [N], by the masses from the top down."""
    count = int(cubes.count)
    power = [mp.mpf(i) / (count - 1) for i in range(count)]
    masses = [mp.mpf(cubes.mass) * mp.mpf(cubes.mass_ratio) ** p for p in power]
    return [mp.mpf(cubes.gravity) * sum(masses[i:]) for i in range(count)]


@pytest.mark.parametrize("mass_ratio", [1.0, 100.0, 0.01, 1e4])
@pytest.mark.parametrize("count", [2, 5])
def test_a_stack_rests_under_its_weight_with_40_digits(count, mass_ratio):
    cubes = replace(STACK, count=count, mass_ratio=mass_ratio, mass=0.7, gravity=1.6)
    with mp.workdps(40):
        weights = [float(weight) for weight in stacked(cubes)]
    np.testing.assert_allclose(cubes.normal_forces, weights, 1e-15)
    assert not cubes.observe(np.linspace(0.0, 10.0, 11))["top"].any()


@pytest.mark.parametrize("mass_ratio", [1.0, 100.0, 0.01])
def test_a_stack_tips_where_a_centre_is_over_an_edge_with_40_digits(mass_ratio):
    leant = replace(STACK, mass_ratio=mass_ratio)
    with mp.workdps(40):
        masses = [mp.mpf(mass_ratio) ** (mp.mpf(i) / 4) for i in range(5)]
        slopes = []
        for face in range(5):
            lifts = [masses[i] * (i - face + mp.mpf(1) / 2) for i in range(face, 5)]
            slopes.append(mp.atan(sum(masses[face:]) / sum(lifts) / 2))
    assert leant.topples == pytest.approx(float(min(slopes)), rel=1e-14)


def tips_in_mujoco(count, name, cone, seconds=3):
    """Whether free cubes tip on a slope [rad]."""
    spec = mujoco.MjSpec()
    below = "floor"
    spec.worldbody.add_geom(name=below, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[9, 9, 1])
    for i in range(count):
        cube = spec.worldbody.add_body(name=f"cube_{i}", pos=[0, 0, STACK.size * (i + 0.5)])
        cube.add_freejoint()
        box = cube.add_geom(name=cube.name, type=mujoco.mjtGeom.mjGEOM_BOX, mass=1.0)
        box.size = [STACK.size / 2] * 3
        box.contype = 0
        box.conaffinity = 0
        spec.add_pair(geomname1=below, geomname2=cube.name, condim=3, friction=[1, 1, 0, 0, 0])
        below = cube.name
    profile = contacts.profile(method(name).settings)
    set_contacts(spec, profile, 1e-3)
    spec.option.timestep, spec.option.cone = 1e-3, cone
    model = spec.compile()
    profile.soften(model)

    def tips(slope):
        data = mujoco.MjData(model)
        for k in range(100 * seconds):
            now = slope * min(1.0, k / 100)
            model.opt.gravity[:] = 9.81 * np.array([math.sin(now), 0.0, -math.cos(now)])
            mujoco.mj_step(model, data, 10)
        return data.body(count).xpos[0] > STACK.size / 2

    return tips


def tips_in_pymunk(count):
    """The same."""

    def tips(slope):
        space = pymunk.Space()
        cubes = []
        space.iterations = 50
        floor = pymunk.Segment(space.static_body, (-9, 0), (9, 0), 0)
        floor.friction = 1.0
        space.add(floor)
        for i in range(count):
            cubes.append(pymunk.Body(1.0, STACK.size**2 / 6))
            cubes[-1].position = 0, STACK.size * (i + 0.5)
            box = pymunk.Poly.create_box(cubes[-1], (STACK.size, STACK.size))
            box.friction = 1.0
            space.add(cubes[-1], box)
        for k in range(3000):
            now = slope * min(1.0, k / 1000)
            space.gravity = 9.81 * math.sin(now), -9.81 * math.cos(now)
            space.step(1e-3)
        return cubes[-1].position.x > STACK.size / 2

    return tips


@pytest.mark.parametrize(
    ("tips", "count", "part"),
    [
        (tips_in_mujoco(2, "mujoco/euler", 0), 2, 0.957),
        (tips_in_mujoco(5, "mujoco/euler", 0), 5, 0.842),
        (tips_in_mujoco(5, "mujoco/euler", 1), 5, 0.913),
        (tips_in_mujoco(5, "mujoco/euler", 0, 6), 5, 0.661),
        (tips_in_mujoco(5, "mujoco/euler+elliptic", 1), 5, 0.961),
        (tips_in_mujoco(5, "mujoco/euler+stiff", 0), 5, 1.0),
        (tips_in_pymunk(5), 5, 1.0),
    ],
    ids=["2 cubes", "default", "elliptic", "default, 6 s", "+elliptic", "+stiff", "pymunk"],
)
def test_free_stacks_tip_where_the_readme_says(tips, count, part):
    exact = math.tan(replace(STACK, count=count).topples)
    assert exact == pytest.approx(1 / count, rel=1e-15)
    assert [tips(math.atan(exact * part * off)) for off in (0.997, 1.003)] == [False, True]


@pytest.mark.parametrize("above", [1.0, 1e4, 1e-4])
def test_the_depth_that_settings_promise_is_that_of_free_cubes(above):
    """Three cubes with six degrees of freedom each, none of plumbob's own."""
    head = pasted("mujoco/euler+stiff", 0.5).mjcf
    masses = [1.0, 1.0, above]
    cubes = "".join(
        f'<body pos="0 0 {0.1 + 0.2 * i}"><freejoint/>'
        f'<geom type="box" size=".1 .1 .1" mass="{mass}"/></body>'
        for i, mass in enumerate(masses)
    )
    world = f'<worldbody><geom type="plane" size="2 2 .1"/>{cubes}</worldbody>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{head}{world}</mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=300)
    loads = 9.81 * np.cumsum(masses[::-1])[::-1] / 4
    weights = model.body_invweight0[1:, 0] + model.body_invweight0[:-1, 0]
    deep = allowed_by("mujoco/euler+stiff") * (loads * weights).sum()
    assert 0.5 - data.xpos[-1, 2] == pytest.approx(deep, rel=2e-3)
    assert np.abs(data.qvel).max() < 1e-9
