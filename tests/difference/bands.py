"""The band of rounding over many models, beside ensembles of nudged runs and real differences.

    python -m plumbob.tests.difference.bands [NAME ...]

Prints a row for each model: how far the band reaches; its mean-square estimate over the spread
of an ensemble of nudged runs, at the end; the largest ratio to the bound of that ensemble, of dense
against sparse Jacobians, and of bodies in another order; these two differences over the estimate;
and the bound over the estimate, without and with the solver.
"""

import copy
import sys
import tempfile
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.adapters.mujoco.own_model.recorded_steps import (
    NUDGED_FORCES,
    _set_fields,
    unit_in_last_place,
)
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.difference.band import BandMeasurement
from plumbob.engines.difference.difference import use_by_kind
from plumbob.engines.difference.recording import recording_of
from plumbob.engines.difference.sample_steps import SampleSteps, StepLaw
from plumbob.engines.recorded_step import StepInput
from plumbob.tests.audit.robots.robot_files import folder
from plumbob.tests.difference.planted_changes import LEGS, Motion

STEPS, RUNS = 120, 8
BADLY = """<mujoco><option timestep=".001"/><worldbody><body>
<joint name="a" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".01" mass="1e-3"/>
<body pos=".3 0 0"><joint name="b" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".01" mass="10"/>
<body pos=".3 0 0"><joint name="c" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".01" mass="1e-3"/>
</body></body></body></worldbody></mujoco>"""
STIFF = """<mujoco><option timestep=".001"/><worldbody>
<geom type="plane" size="9 9 1" solref="-1e6 -1e3"/>
<body pos="0 0 .1005"><freejoint/>
<geom type="box" size=".1 .1 .1" mass="1" solref="-1e6 -1e3"/></body>
</worldbody></mujoco>"""
TEXTS = {**LEGS, "badly conditioned": BADLY, "stiff contact": STIFF}
FILES = {
    **{
        f"gymnasium/{name}": ("gymnasium", name)
        for name in (
            "half_cheetah",
            "ant",
            "humanoid",
            "hopper",
            "walker2d",
            "swimmer",
            "reacher",
            "pusher",
            "inverted_double_pendulum",
            "inverted_pendulum",
            "humanoidstandup",
            "point",
        )
    },
    **{
        f"dm_control/{name}": ("dm_control", name)
        for name in (
            "cheetah",
            "humanoid",
            "walker",
            "hopper",
            "acrobot",
            "finger",
            "ball_in_cup",
            "cartpole",
            "reacher",
            "swimmer",
            "fish",
            "manipulator",
            "quadruped",
            "pendulum",
            "humanoid_CMU",
        )
    },
}


def compiled(name):
    """A model, and the same with its bodies in another order; None where that cannot be built."""
    if name in TEXTS:
        text, base = TEXTS[name], Path(".")
    else:
        package, file = FILES[name]
        base = folder(package)
        text = (base / f"{file}.xml").read_text("utf-8")
    with tempfile.TemporaryDirectory() as temporary:
        there = Path(temporary)
        for entry in base.glob("*") if name not in TEXTS else ():
            (there / entry.name).symlink_to(entry)
        root = ElementTree.fromstring(text)
        for element in root.iter("worldbody"):
            reverse(element)
        plain, other = there / "plain_model.xml", there / "other_model.xml"
        plain.write_text(text)
        other.write_text(ElementTree.tostring(root, "unicode"))
        return [mujoco.MjModel.from_xml_path(str(path)) for path in (plain, other)]


def reverse(element):
    """Puts the bodies in an element in the opposite order."""
    places = [k for k, child in enumerate(element) if child.tag == "body"]
    bodies = [element[k] for k in places]
    for place, body in zip(places, reversed(bodies), strict=True):
        element[place] = body
        reverse(body)


def in_order(model, other, motion):
    """The states of a model with its bodies in another order, in the order of the first."""
    positions, velocities = [], []
    for joint in range(model.njnt):
        name = model.joint(joint).name
        there = other.joint(name).id if name else joint
        for into, kind, firsts in (
            (positions, "qpos", other.jnt_qposadr),
            (velocities, "qvel", other.jnt_dofadr),
        ):
            size = len(getattr(mujoco.MjData(model).joint(joint), kind))
            into.extend(range(firsts[there], firsts[there] + size))
    data = mujoco.MjData(other)
    rows = []
    for control in motion.controls:
        rows.append(np.concatenate([data.qpos[positions], data.qvel[velocities], data.act]))
        for k, value in enumerate(control):
            name = model.actuator(k).name
            data.ctrl[other.actuator(name).id if name else k] = value
        mujoco.mj_step(other, data)
    return np.array(rows)


def nudged_run(samples, motion, end, rng):
    """The states of a run in which each step is nudged by units in the last place."""
    steps = samples.steps
    before = StepInput(motion.states[0], motion.controls[:1], motion.warm[0])
    numbers = steps._nudged_numbers(np.float64)

    def moved(values):
        return values + rng.choice([-1.0, 1.0], values.shape) * unit_in_last_place(
            values, float
        )

    rows = [before.state]
    for step in range(end):
        steps.after(before)
        forces = sum(np.abs(getattr(steps.data, name)) for name in NUDGED_FORCES)
        _set_fields(steps.changed, numbers[rng.integers(len(numbers))])
        force = rng.choice([-1.0, 1.0], forces.size) * unit_in_last_place(forces, float)
        start = StepInput(*map(moved, (before.state, before.controls, before.warm_start)))
        after = steps._after(steps.changed, steps.changed_data, start, force)
        before = StepInput(after.state, motion.controls[step + 1 : step + 2], after.warm_start)
        rows.append(after.state)
    steps._restore()
    return np.array(rows)


def row(name):
    """The cells of a model's row."""
    model, other = compiled(name)
    own = own_model(model, name)
    motion = Motion(model, STEPS)
    recording = recording_of(motion.arrays(warm=True), "a", own)
    samples = SampleSteps(own, recording, StepLaw(own.integrator, own.step))
    size = 2 * model.nv + model.na
    band = BandMeasurement(samples, Allowance(60.0), np.float64).band(0, np.zeros(size))
    rng = np.random.default_rng(7)
    runs = np.array([nudged_run(samples, motion, band.end, rng) for _ in range(RUNS)])
    changes = samples.space.differences(
        runs, np.broadcast_to(motion.states[: band.end + 1], runs.shape)
    )
    spread = np.sqrt(np.mean(changes[:, band.end] ** 2, axis=0))
    last = band.samples[-1]
    dense = copy.copy(model)
    dense.opt.jacobian = 0 if mujoco.mj_isSparse(model) else 1
    reals = [Motion(dense, STEPS).states, in_order(model, other, motion)]
    reals = [
        samples.space.differences(states, motion.states)[: band.end + 1] for states in reals
    ]
    unit = np.spacing(np.abs(motion.states).max())

    def use(rows):
        return max(
            use_by_kind(rows[k + 1], band.samples[k].bound + unit, model.nv)
            for k in range(band.end)
        )

    estimate = np.linalg.norm(last.estimate)
    ratio = estimate / np.linalg.norm(spread)
    real = [np.linalg.norm(rows[-1]) / estimate for rows in reals]
    uses = [max(map(use, changes)), *map(use, reals)]
    wide = (last.rounding.max() / last.estimate.max(), last.bound.max() / last.estimate.max())
    return [
        name,
        f"{band.end} {band.why}",
        f"{ratio:.2f}",
        *(f"{u:.2g}" for u in uses),
        *(f"{r:.2g}" for r in real),
        *(f"{w:.3g}" for w in wide),
    ]


def main(names):
    """Prints the table of some models, or all."""
    head = (
        "model",
        "reaches",
        "estimate/ensemble",
        "ensemble/bound",
        "dense/bound",
        "order/bound",
        "dense/estimate",
        "order/estimate",
        "rounding/estimate",
        "bound/estimate",
    )
    print("|", " | ".join(head), "|", flush=True)
    for name in names or (*TEXTS, *FILES):
        try:
            print("|", " | ".join(row(name)), "|", flush=True)
        except Exception as error:
            print("|", name, "|", repr(error)[:150], "|", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
