"""Recorded motions of a model with a planted change: a step that is not the model's, samples that
are out of order, another control, integrator or precision."""

import copy

import mujoco
import numpy as np

SEED = 3


def state_of(data):
    return np.concatenate([data.qpos, data.qvel, data.act])


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
            models[id(model)] = changed(copy.copy(model))
        mujoco.mj_step(models[id(model)], data)

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
