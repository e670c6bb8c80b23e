"""Derivatives that an audit certifies of robots, held against another eps and another method.

    python -m plumbob.tests.audit.robots.gradients [NAME ...]

Prints a row for a half cheetah that falls and one on the ground, a cart-pole, and an arm with a
motor in each joint: how well the gradient of the last pose is certified, the errors of three ways
at the file's own step, the horizon, and how far two other computations are from it, of the
certificate: DOP853 with another tolerance and eps, and differences of the file's own RK4 at steps
that end where contacts do. Exits 1 where one is outside.
"""

import copy
import importlib.util
import sys
from functools import partial
from pathlib import Path

import mujoco
import numpy as np

from plumbob.engines.adapters.mujoco.own_model.field import without_step
from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.adapters.mujoco.terms import put, state_of
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.gradient import (
    TIGHT,
    _extrapolated_difference,
    _shifted_script,
    certified_gradient,
)
from plumbob.engines.audit.reference import certified
from plumbob.engines.own_motion import AS_IT_STANDS, Start
from plumbob.tests.audit.robots.robot_files import folder

ANOTHER = ("DOP853", TIGHT / 10.0, 1.3e-3)
# Of own steps: what one may differ by from two of half its size, its least size [s], and eps.
TOLERANCE, SHORTEST, EPS = 1e-12, 1e-14, 5e-4
MOST = 2.0  # certificates: each of two computations may be one off
BUDGET = 1200.0  # [s] of processor time
WAYS = "transition", "central", "forward"
HEAD = "robot", "numbers", "certified", *WAYS, "horizon", "apart", "apart by own steps"


def arm():
    """The Panda of dm-robotics-panda with a motor in each joint, its pins without dry friction."""
    spec = importlib.util.find_spec("dm_robotics.panda")
    assert spec is not None
    assert spec.origin is not None
    panda = mujoco.MjSpec.from_file(str(Path(spec.origin).parent / "assets/panda/panda.xml"))
    for joint in panda.joints:
        joint.frictionloss, joint.damping = 0.0, np.abs(joint.damping)
        motor = panda.add_actuator(name=joint.name, target=joint.name)
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.ctrllimited = True
        motor.ctrlrange = [-0.5, 0.5]
    return panda.compile()


def from_file(package, name):
    return mujoco.MjModel.from_xml_path(str(folder(package) / f"{name}.xml"))


HIGH = Start(qpos=(0.0, 1.0, *[0.0] * 7))
READY = Start(qpos=(0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785))
CHEETAH = partial(from_file, "gymnasium", "half_cheetah")
ROBOTS = {  # its model, its start, and how long [s]
    "half_cheetah in the air": (CHEETAH, HIGH, 0.4),
    "half_cheetah": (CHEETAH, AS_IT_STANDS, 0.4),
    "cartpole": (partial(from_file, "dm_control", "cartpole"), AS_IT_STANDS, 1.0),
    "panda": (arm, READY, 0.2),
}


def ended(own, motion):
    """The last state by the file's own RK4, each step of it beside two of half its size, which are
    as small as a contact that begins or ends needs."""
    model = without_step(copy.copy(own.effective))
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    data = own._new_data(model)
    state = motion.start
    size = motion.period

    def stepped(count):
        put(data, state)
        model.opt.timestep = size / count
        mujoco.mj_step(model, data, count)
        return state_of(data)

    for control in motion.controls:
        data.ctrl[:] = control
        left = motion.period
        while left > SHORTEST:
            size = min(size, left)
            wide = stepped(1)
            narrow = stepped(2)
            off = np.abs(wide - narrow).max()
            if off <= TOLERANCE or size <= SHORTEST:
                state = narrow
                left = left - size
            size *= min(10.0, max(0.1, (TOLERANCE / max(off, SHORTEST)) ** (1 / 5)))
    return state


def by_own_steps(own, motion, number):
    """Eq. 1 at the end, of the file's own RK4."""

    def difference(eps):
        ends = (
            ended(own, _shifted_script(own, motion, number, by))[None] for by in (eps, -eps)
        )
        return own.coordinates(*ends)[0] / (2.0 * eps)

    return (4.0 * difference(EPS / 2.0) - difference(EPS)) / 3.0


def row(name):
    """The gradient of a robot as cells, and whether both computations confirm it."""
    build, start, duration = ROBOTS[name]
    own = own_model(build(), name, start)
    allowance = Allowance(BUDGET)
    motion = script(own, "sines", duration)
    reference = certified(own, motion, allowance)
    found = certified_gradient(own, motion, reference, len(motion.controls), allowance)
    numbers = np.flatnonzero(found.known)
    other, steps = (np.full_like(found.exact[-1], np.nan) for _ in range(2))
    for number in numbers:
        other[:, number] = _extrapolated_difference(own, motion, number, ANOTHER, allowance)[0][
            -1
        ]
        steps[:, number] = by_own_steps(own, motion, number)
    exact = found.exact[-1]
    known = float(found.certificate[-1])
    apart = [float(found.norm(each - exact) / found.norm(exact)) for each in (other, steps)]
    ways = [
        f"{found.errors(w)[-1]:.2g}" if w.computed is not None else w.why for w in found.ways
    ]
    horizon = f"{found.horizon:.2g} s" if found.horizon else found.why
    cells = [name, f"{numbers.size} of {len(found.by)}", f"{known:.1e}", *ways, horizon]
    return [*cells, *(f"{each:.1e}" for each in apart)], max(apart) <= MOST * known


def main(names):
    """Print the table of some robots, or all; returns an exit code."""
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}", flush=True)
    outside = 0
    for name in names or ROBOTS:
        cells, confirmed = row(name)
        outside += not confirmed
        print(f"| {' | '.join(cells)} |{'' if confirmed else ' OUTSIDE'}", flush=True)
    return int(bool(outside))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
