"""Bodies that turn about their own centres of mass: the audit sees it, in metres and in radians.

Free bodies are held against their exact rotation, which shares no code with the audit; a wheel and
gears, which have no closed form, against steps 256 times smaller. Corners are worked out here
from the text of each model."""

import json
import re
from dataclasses import replace
from functools import cache
from itertools import product

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit import reference as reference_module
from plumbob.engines.audit import step_errors
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import certified, known_part
from plumbob.engines.audit.step_errors import error_at_step, state_errors
from plumbob.engines.own_motion import Start
from plumbob.reports.cli import main
from plumbob.reports.view.audit.page import answer_lines, audit_answer
from plumbob.tests.audit.scenes_as_models import audit_of, compiled
from plumbob.tests.support.exact_rotation import attitudes

SIGNS = np.array(list(product((-1.0, 1.0), repeat=3)))
SPIN = """<mujoco><option gravity="0 0 0" timestep="0.001" integrator="implicitfast"/><worldbody>
<body><freejoint/><inertial pos="0 0 0" mass="{}" diaginertia="{} {} {}"/></body>
</worldbody></mujoco>"""
SPIN_MASS, SPIN_MOMENTS, SPIN_START = 0.12, (1.7e-4, 6.6e-6, 1.71e-4), (0.1, 50.0, 3.0)
# A handle along x across a bar along y, which turns about the axis of its middle moment.
HANDLE = """<mujoco><option gravity="0 0 0" timestep="0.002" integrator="{}"/><worldbody>
<body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="2e-3 1.2e-3 3e-3"/>
  <geom type="box" size=".05 .01 .02" pos=".06 0 0" contype="0" conaffinity="0"/>
  <geom type="capsule" size=".01 .09" pos=".01 0 0" euler="90 0 0" group="3"/></body>
</worldbody></mujoco>"""
HANDLE_MOMENTS, HANDLE_START = (2e-3, 1.2e-3, 3e-3), (6.0, 0.02, -0.03)
HANDLE_CORNERS = np.concatenate(
    [
        SIGNS * (0.05, 0.01, 0.02) + (0.06, 0.0, 0.0),
        SIGNS * (0.01, 0.1, 0.01) + (0.01, 0.0, 0.0),
    ]
)
WHEEL = """<mujoco><option timestep="0.005"/><worldbody><body><joint name="axle" axis="0 0 1"
  damping="0.002"/><geom type="cylinder" size="0.1 0.01" mass="1"/></body></worldbody>
<actuator><position joint="axle" kp="20" kv="0.1"/></actuator></mujoco>"""
GEARS = """<mujoco><option timestep="0.004"/><worldbody>
<body><joint name="a" axis="0 0 1" stiffness="0.5"/><geom type="cylinder" size=".1 .01" mass="1"/>
</body><body pos=".3 0 0"><joint name="b" axis="0 0 1"/><geom type="cylinder" size=".2 .01"
  mass="2" contype="0" conaffinity="0"/></body></worldbody>
<equality><joint joint1="a" joint2="b" polycoef="0 -2 0 0 0" solref="0.05 1"/></equality>
</mujoco>"""
TURNING = {  # a model, its start, half the sides of the boxes of both wheels
    "wheel": (WHEEL, (0.5,), ((0.1, 0.1, 0.01),)),
    "gears": (GEARS, (0.5, -0.25), ((0.1, 0.1, 0.01), (0.2, 0.2, 0.01))),
}
KEY = '<keyframe><key qpos="0.5"/></keyframe></mujoco>'
FINE = 256


def inertia_corners(mass, moments):
    """The corners [m] of the box of a mass and moments: m (b^2 + c^2) / 3 = I1 and so on."""
    squares = np.linalg.solve(mass / 3.0 * (1.0 - np.eye(3)), moments)
    return SIGNS * np.sqrt(np.maximum(squares, 0.0))


def turned(quaternions, corners):
    """Corners [m] that turn with a body, shape (n, corners, 3)."""
    turns = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
    return np.einsum("nij,kj->nki", turns, corners)


def displacement(here, there):
    """The largest displacement [m] of a corner so far, shape (n,)."""
    return np.maximum.accumulate(np.linalg.norm(here - there, axis=2).max(axis=1))


def angle(here, there):
    """The largest angle [rad] between attitudes."""
    both = (Rotation.from_quat(of, scalar_first=True) for of in (here, there))
    first, second = both
    return float((first.inv() * second).magnitude().max())


def stepped(model, start, controls, parts):
    """Quaternions of MuJoCo's own steps of a free body, each control period of `parts` steps."""
    data = mujoco.MjData(model)
    data.qvel[3:] = start
    quaternions = [data.qpos[3:].copy()]
    for _ in range(controls):
        mujoco.mj_step(model, data, parts)
        quaternions.append(data.qpos[3:].copy())
    return np.array(quaternions)


@cache
def handle_answer():
    """The exact attitudes of the handle at the ends of 75 control periods, 1.5 s."""
    return attitudes(HANDLE_MOMENTS, HANDLE_START, 0.02 * np.arange(76))


@pytest.mark.parametrize("integrator", ["Euler", "RK4", "implicit", "implicitfast"])
def test_a_handle_that_turns_over_is_as_wrong_as_its_exact_rotation_says(integrator):
    exact = handle_answer()
    model = compiled(HANDLE.format(integrator))
    own = own_model(model, "handle", Start(qvel=(0.0, 0.0, 0.0, *HANDLE_START)))
    motion = script(own, duration=1.5)
    reference = certified(own, motion, Allowance(60.0))
    truth = turned(exact, HANDLE_CORNERS)
    known = float(reference.uncertainty[-1])
    assert known < 1e-6
    certified_to = turned(reference.states[:, 3:7], HANDLE_CORNERS)
    assert (displacement(certified_to, truth) <= reference.uncertainty + 1e-15).all()
    run = stepped(model, HANDLE_START, 75, 10)
    found = error_at_step(own, motion, reference, own.integrator, 10)
    apart = displacement(turned(run, HANDLE_CORNERS), truth)
    assert found.errors == pytest.approx(apart, abs=known)
    assert found.worst == "body 1"
    assert apart[-1] > 1e3 * known  # so that a wrong measure shows
    states = own.stepped(motion, own.integrator, 10).states
    beside = state_errors(own, reference.states, states)
    # The corner that is 1 cm and more from any axis moves by that times the angle.
    assert beside.attitude == pytest.approx(angle(run, exact), abs=known / 0.01)


@pytest.fixture(name="few_steps")
def _few_steps(monkeypatch):
    """Audits at the own step and a half of it."""
    monkeypatch.setattr(step_errors, "HALVINGS", 1)


@pytest.mark.usefixtures("few_steps")
def test_a_body_that_only_turns_fails_in_metres_and_says_its_angle(tmp_path, capsys):
    (file := tmp_path / "spin.xml").write_text(SPIN.format(SPIN_MASS, *SPIN_MOMENTS))
    words = ["--qvel", "0,0,0,0.1,50,3", "--duration", "2", "--absolute", "1e-6", "--json"]
    assert (
        main(["audit", str(file), *words, "--require-reference", "--out", str(tmp_path)]) == 1
    )
    printed = capsys.readouterr()
    data = json.loads(printed.out)
    assert "more than 1e-06 m" in printed.err
    exact = attitudes(SPIN_MOMENTS, SPIN_START, 0.02 * np.arange(101))
    run = stepped(mujoco.MjModel.from_xml_path(str(file)), SPIN_START, 100, 20)
    corners = inertia_corners(SPIN_MASS, SPIN_MOMENTS)
    apart = displacement(turned(run, corners), turned(exact, corners))
    assert data["error_measure"] == "corner displacement"
    assert data["error_over_time"] == pytest.approx(apart, abs=data["uncertainty"])
    assert data["error"] == pytest.approx(0.0957, rel=1e-3)
    least = float(corners.max(axis=0).min())  # [m] of a corner from any axis, at least
    assert data["attitude_error"] == pytest.approx(
        angle(run, exact), abs=data["uncertainty"] / least
    )
    assert data["attitude_error"] == pytest.approx(2.5535, abs=1e-4)


@pytest.mark.usefixtures("few_steps")
@pytest.mark.parametrize("name", TURNING)
def test_wheels_are_as_wrong_as_small_steps_say(name):
    text, start, sizes = TURNING[name]
    own = own_model(compiled(text), name, Start(qpos=start))
    found = audit_of(own, duration=0.5)
    parts = found.found.own.parts
    nq = len(start)
    coarse, fine = (
        own.stepped(found.script, integrator, parts * factor).states[:, :nq]
        for integrator, factor in (("euler", 1), ("rk4", FINE))
    )
    # A point at a distance r from the axis of a turn by an angle moves by 2 r sin(angle / 2).
    radii = np.array([np.hypot(*size[:2]) for size in sizes])
    apart = 2.0 * radii * np.sin(np.abs(coarse - fine) / 2.0)
    # What RK4 leaves at such steps, with constraints whose forces have corners in time.
    left = 1e-8
    assert found.error == pytest.approx(apart.max(), abs=found.uncertainty + left)
    assert found.resolved
    turned_by = np.abs(coarse - fine).max()
    assert found.state_errors.attitude == pytest.approx(turned_by, abs=1e-6)
    assert found.state_errors.coordinates == pytest.approx(turned_by, abs=1e-6)
    assert found.error > 1e3 * left


# A body of geoms of every kind, one of inertia alone that hangs on it, and one of neither.
KINDS = """<mujoco><asset><mesh name="wedge" vertex="0 0 0 .1 0 0 0 .2 0 .1 .1 .3"/></asset>
<worldbody><geom type="plane" size="1 1 1"/><geom type="box" size="1 1 1" pos="9 9 9"/>
<body name="all"><freejoint/><geom size=".1" pos=".3 .1 0"/>
  <geom type="capsule" size=".1 .2" euler="10 20 30"/>
  <geom type="ellipsoid" size=".1 .2 .3" pos="0 0 .5" contype="0" conaffinity="0" group="2"/>
  <geom type="cylinder" size=".1 .2" pos="0 -.4 0"/><geom type="box" size=".3 .02 .1"/>
  <geom type="mesh" mesh="wedge" pos="-.5 0 0" euler="0 40 0" mass="0"/>
  <body name="bare" pos=".1 .2 .3"><joint axis="1 2 3"/>
    <inertial pos=".1 0 0" quat="1 2 3 4" mass="2" diaginertia=".03 .02 .04"/>
    <body name="nothing" pos="0 .5 0"/></body></body>
</worldbody></mujoco>"""


def boxes_of(model, data, body):
    """All corners [m] of a body's boxes where `data` has them, shape (corners, 3)."""
    corners = []
    for geom in np.flatnonzero(model.geom_bodyid == body):
        box = model.geom_aabb[geom]
        local = box[:3] + SIGNS * box[3:]
        corners.append(local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])
    if not corners and model.body_mass[body]:
        local = inertia_corners(model.body_mass[body], model.body_inertia[body])
        corners.append(local @ data.ximat[body].reshape(3, 3).T + data.xipos[body])
    return np.concatenate(corners or [data.xpos[[body]]])


def test_corners_are_those_of_the_boxes_of_geoms_or_of_inertia():
    """No corner of a box moves further than those that are kept, and none of these more; a mesh is
    inside its box; what cannot move has one point."""
    model = compiled(KINDS)
    own = own_model(model, "kinds")
    assert np.bincount(own.corner_bodies)[[0, 3]].tolist() == [1, 1]
    assert np.bincount(own.corner_bodies)[2] == 8
    wedge = int(np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH)[0])
    reach = np.abs(model.mesh_vert - model.geom_aabb[wedge, :3]) - model.geom_aabb[wedge, 3:]
    assert abs(reach.max()) < 1e-6  # vertices are in single precision
    random = np.random.default_rng(0)
    states = np.hstack([random.normal(size=(6, model.nq)), np.zeros((6, model.nv))])
    data = mujoco.MjData(model)
    brute = []
    for state in states:
        data.qpos[:] = state[: model.nq]
        mujoco.mj_forward(model, data)
        brute.append([boxes_of(model, data, body) for body in range(model.nbody)])
    corners = own.corners(states)
    for (k, here), (other, there) in product(enumerate(brute), repeat=2):
        apart = np.linalg.norm(corners[k] - corners[other], axis=1)
        for body in range(1, model.nbody):
            most = np.linalg.norm(here[body] - there[body], axis=1).max()
            assert apart[own.corner_bodies == body].max() == pytest.approx(most, abs=1e-12)


FILTER = """<mujoco><option timestep="0.01"/><worldbody><body><joint name="j"/>
<geom size=".1" mass="1"/></body></worldbody><actuator><general joint="j" dyntype="filter"
  dynprm=".1" gainprm="0" ctrlrange="-1 1"/></actuator></mujoco>"""


@pytest.mark.usefixtures("few_steps")
def test_an_activation_that_changes_is_no_stillness():
    """It follows 1 - exp(-t/T), and (1 - h/T)^n of that is left by Euler's steps."""
    own = own_model(compiled(FILTER), "filter")
    rest = audit_of(own, "zero", duration=0.1)
    assert rest.still
    assert "nothing moves" in "".join(answer_lines(audit_answer(rest)))
    found = audit_of(own, np.ones((5, 1)), duration=0.1)
    assert (found.error, found.still) == (0.0, False)
    steps = np.array([2, 4, 6, 8, 10])
    left = np.abs((1.0 - 0.1) ** steps - np.exp(-0.1 * steps)).max()
    assert found.state_errors.activations == pytest.approx(left, abs=1e-8)
    assert found.state_errors.attitude == found.state_errors.coordinates == 0.0
    assert "nothing moves" not in "".join(
        answer_lines(audit_answer(replace(found, control="ones")))
    )


@pytest.mark.usefixtures("few_steps")
def test_a_certificate_as_large_as_the_motion_is_none(monkeypatch, tmp_path, capsys):
    """The second method leaves the rod where it starts: both differ by the motion."""
    computed = reference_module.integration

    def unmoved(model, script, method, *more):
        found = computed(model, script, method, *more)
        states = np.broadcast_to(script.start, found.states.shape)
        return found if method == "DOP853" else replace(found, states=states)

    monkeypatch.setattr(reference_module, "integration", unmoved)
    (file := tmp_path / "wheel.xml").write_text(WHEEL.replace("</mujoco>", KEY))
    words = ["audit", str(file), "--keyframe", "0", "--duration", "0.1", "--budget", "5"]
    assert main([*words, "--verbose"]) == 0
    said = re.search(
        "reference +none: known to ±(.*) m only, the motion is (.*) m", capsys.readouterr().out
    )
    assert said is not None
    assert float(said[1]) == pytest.approx(float(said[2]), rel=0.05)  # their digits
    assert main([*words, "--json", "--require-reference"]) == 1
    printed = capsys.readouterr()
    assert json.loads(printed.out)["error"] is None
    assert "no reference beyond 0 s: known to ±" in printed.err


def test_a_certificate_ends_where_the_motion_is_larger_for_the_last_time():
    own = own_model(compiled(WHEEL), "wheel", Start(qpos=(0.5,)))
    found = certified(own, script(own, duration=0.1), Allowance(60.0))
    moved = displacement(found.corners[:1], found.corners)
    for most, known in ((0.9, 5), (1.1, 2)):
        factors = np.array([0.0, 1.5, 0.9, most, most, most])
        cut = known_part(replace(found, uncertainty=factors * moved))
        assert cut.known == known
        assert bool(cut.why) == (known < 5)
    still = known_part(replace(found, corners=0.0 * found.corners))
    assert still.known == 5  # what rounding leaves is no motion: nothing is lost
