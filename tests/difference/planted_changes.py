"""Recorded motions of a model with a planted change: a step that is not the model's, samples that
are out of order, another control, integrator or precision."""

import copy

import mujoco
import numpy as np

from plumbob.engines.adapters.mujoco.terms import state_of

SEED = 3


def sines(model, step):
    actuators = np.arange(model.nu)
    time = step * model.opt.timestep
    return 0.3 * np.sin(2 * np.pi * (0.7 + 0.13 * actuators) * time + actuators)


class Motion:
    """A motion under sines, recorded at each step, in which one step may be taken by another
    function of (model, data, step)."""

    def __init__(self, model, steps=120, at=None, other=None, precision=None, controls=sines):
        data = mujoco.MjData(model)
        rows, warm, held, touched = [], [], [], []
        for step in range(steps + 1):
            data.ctrl[:] = controls(model, step)
            rows.append(state_of(data))
            warm.append(data.qacc_warmstart.copy())
            held.append(data.ctrl.copy())
            if other is not None and at in (None, step):
                other(model, data, step)
            else:
                mujoco.mj_step(model, data)
            touched.append({tuple(sorted(pair)) for pair in data.contact.geom.tolist()})
            if precision is not None:
                for values in (data.qpos, data.qvel, data.act):
                    values[:] = values.astype(precision)
        self.model, self.states, self.controls = model, np.array(rows), np.array(held)
        self.warm, self.touched = np.array(warm), touched
        self.times = model.opt.timestep * np.arange(steps + 1)

    def arrays(self, rows=slice(None), warm=False, times=None):
        """The recording as arrays by name."""
        nq, nv = self.model.nq, self.model.nv
        states = self.states[rows]
        arrays = {
            "time": self.times[rows] if times is None else times,
            "qpos": states[:, :nq],
            "qvel": states[:, nq : nq + nv],
            "act": states[:, nq + nv :],
            "ctrl": self.controls[rows],
        }
        return arrays | ({"qacc_warmstart": self.warm[rows]} if warm else {})


def stepped_by(changed):
    """A step of a changed copy of the model."""
    models = {}

    def step(model, data, _):
        if id(model) not in models:
            # The model is kept, too: another model would get its number after its end.
            models[id(model)] = model, changed(copy.copy(model))
        mujoco.mj_step(models[id(model)][1], data)

    return step


def gravity(factor):
    def change(model):
        model.opt.gravity[:] *= factor
        return model

    return stepped_by(change)


def integrator(number):
    def change(model):
        model.opt.integrator = number
        return model

    return stepped_by(change)


def without(geom):
    def change(model):
        model.geom_contype[geom] = model.geom_conaffinity[geom] = 0
        return model

    return stepped_by(change)


def pushed(degree, amount):
    """The model's step with a velocity that is larger by an amount."""

    def step(model, data, _):
        mujoco.mj_step(model, data)
        data.qvel[degree] += amount

    return step


def control_of(before):
    """A step under the control of a step before."""

    def step(model, data, number):
        data.ctrl[:] = sines(model, max(number - before, 0))
        mujoco.mj_step(model, data)

    return step


def first_contact(motion, least):
    """The first step from `least` on with a contact whose moving geom touches nothing else in a way
    that matters, and its geoms; None if nothing touches."""
    for step in range(least, len(motion.touched)):
        for pair in sorted(motion.touched[step]):
            return step, pair
    return None


ROW = 60  # row of the sample before the step that is changed


def _one_step(other, kind, part=""):
    """A plant of one step that another function takes, and the finding that is expected."""
    return lambda model: (Motion(model, at=ROW, other=other).arrays(), (ROW, kind, part))


def _rows(order, row, kind, times=True):
    """A plant of samples in another order, with regular times or with their own."""

    def plant(model):
        motion = Motion(model)
        rows = order(list(range(len(motion.times))))
        regular = motion.times[: len(rows)] if times else None
        return motion.arrays(rows, times=regular), (row, kind, "")

    return plant


def _contact(model):
    motion = Motion(model)
    step, pair = first_contact(motion, ROW)
    moving = next(geom for geom in pair if model.body_weldid[model.geom_bodyid[geom]])
    other = without(moving)
    return Motion(model, at=step, other=other).arrays(), (
        step,
        "contact",
        model.geom(moving).name,
    )


def other_integrator(model):
    """RK4 for a model that has another integrator, else Euler. (Euler and implicitfast may be the
    same step.)"""
    kinds = mujoco.mjtIntegrator
    is_rk4 = model.opt.integrator == kinds.mjINT_RK4
    return ("euler", kinds.mjINT_EULER) if is_rk4 else ("rk4", kinds.mjINT_RK4)


def _integrator(model):
    name, number = other_integrator(model)
    arrays = Motion(model, at=ROW, other=integrator(number)).arrays()
    return arrays, (ROW, "integrator", name)


PLANTS = {
    "a contact left out": _contact,
    "gravity": _one_step(gravity(1.0 + 1e-6), "factor", "gravity"),
    "a control late": _one_step(control_of(1), "late"),
    "another integrator": _integrator,
    "a sample repeated": _rows(lambda rows: [*rows[: ROW + 1], *rows[ROW:-1]], ROW, "repeated"),
    "a sample dropped": _rows(lambda rows: rows[:ROW] + rows[ROW + 1 :], ROW - 1, "dropped"),
    "a sample and its time dropped": _rows(
        lambda rows: rows[:ROW] + rows[ROW + 1 :], ROW - 1, "dropped", False
    ),
    "samples swapped": _rows(
        lambda rows: [*rows[:ROW], ROW + 1, ROW, *rows[ROW + 2 :]], ROW - 1, "swapped"
    ),
}


def halved(model):
    """A motion at half the model's step, of which every second sample is recorded."""
    finer = copy.copy(model)
    finer.opt.timestep /= 2.0
    held = Motion(finer, 200, controls=lambda _, step: sines(model, step // 2))
    return held.arrays(slice(None, None, 2))


LEG = """
<mujoco model="leg">
  <option timestep="0.002" integrator="{integrator}" {solver}/>
  <worldbody>
    <geom name="floor" type="plane" size="9 9 .1" friction=".8"/>
    <body name="hip" pos="0 0 .78">
      <joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/>
      <joint name="pitch" axis="0 1 0" damping=".1"/>
      <geom name="trunk" type="box" size=".15 .1 .05" mass="5"/>
      <body name="thigh"><joint name="hip_pitch" axis="0 1 0" damping=".5" armature=".01"/>
        <geom name="thigh" type="capsule" fromto="0 0 0 .1 0 -.36" size=".03" mass="1"/>
        <body name="shank" pos=".1 0 -.36">
          <joint name="knee" axis="0 1 0" damping=".5" range="-100 -5" limited="true"/>
          <geom name="shank" type="capsule" fromto="0 0 0 -.08 0 -.36" size=".02" mass=".6"/>
          <geom name="heel" type="sphere" pos="-.08 0 -.38" size=".03" mass=".2"/>
        </body></body></body>
    <body name="ball" pos=".5 0 .2"><freejoint name="ball"/>
      <geom name="ball" type="ellipsoid" size=".1 .08 .06" mass=".5"/></body>
  </worldbody>
  <actuator>
    <motor name="hip" joint="hip_pitch" gear="20"/>
    <general name="knee" joint="knee" gear="20" dyntype="filter" dynprm=".05" gainprm="1"/>
  </actuator>
</mujoco>
"""
LEGS = {
    "euler": LEG.format(integrator="Euler", solver=""),
    "implicitfast, elliptic, CG": LEG.format(
        integrator="implicitfast", solver='cone="elliptic" solver="CG"'
    ),
    "RK4, PGS at its cap": LEG.format(integrator="RK4", solver='solver="PGS" iterations="4"'),
}
