"""The steps of a MuJoCo model beside neighbouring ones: Jacobians of a step, growth of a nudge.

The tangent space of a model is that of its positions (`mj_integratePos`, `mj_differentiatePos`),
beside velocities and activations.
"""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.options import collected
from plumbob.engines.adapters.mujoco.own_model.field import converging
from plumbob.engines.adapters.mujoco.own_model.left_out import apply
from plumbob.engines.adapters.mujoco.own_model.places import place
from plumbob.engines.adapters.mujoco.terms import apart, put, shifted, state_of
from plumbob.engines.own_motion import OUT_OF_TIME, Change, NotCertifiable, Place, Script

# [m, rad, ...] of the state, along a direction by chance. An unstable contact chatters: a
# nudge's growth ends where it opens, at some 1e-5 m, which is to be more than a thousandfold.
NUDGE = 1e-9
SURELY = 10.0  # times faster than the first one, no later difference of a Jacobian is
LAST = 10  # one in so many steps of a run is at its end
AT_REST = 1e-9  # [m, rad, m/s, ...] by which a state at rest changes in a step
DIFFERENCE = 1e-7  # [m, rad, ...] of the Jacobians that find it
NEUTRAL = 1e-7  # of the stiffest direction: one as soft has no place of rest
_BAD = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)


def kind(integrator: str) -> Any:
    """MuJoCo's number of an integrator."""
    return getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")


def diverged(data: Any) -> bool:
    """Whether MuJoCo has warned of numbers without bounds, or some are none."""
    warned = any(data.warning[bad].number for bad in _BAD)
    return warned or not np.isfinite(data.qpos).all()


def in_time(ends: float, least: float = 0.0) -> None:
    """Raise NotCertifiable if what takes at least so many seconds more of processor time ends after
    the processor time `ends` [s]."""
    if time.process_time() + least > ends:
        raise NotCertifiable(OUT_OF_TIME)


class TangentMaps:
    """Jacobians of one step of a model from the state and control of an mjData. The
    constraint solver runs to its floor, always from the same forces, so that a step is a function
    of its state alone."""

    def __init__(
        self, model: Any, data: Any, state: Array, control: Array, ends: float = math.inf
    ) -> None:
        """The model is one of `for_maps`, which all that share it leave as it is but for its step
        and integrator. From the processor time `ends` [s] on NotCertifiable is raised."""
        self.model, self.data, self.state, self.control = model, data, state, control
        self.ends = ends
        put(data, state)
        data.ctrl[:] = control
        mujoco.mj_forward(model, data)
        self.warm = data.qacc.copy()
        self.size = 2 * model.nv + model.na

    @collected()
    def __call__(
        self, integrator: str, step: float, difference: float, directions: Array | None = None
    ) -> Array:
        """The Jacobian of one step [s] by central differences of a size [m, rad, ...], shape (n,
        n); times `directions`, shape (n, k), if given. Raises NotCertifiable after the first
        difference where the others would take far too long."""
        count = self.size if directions is None else directions.shape[1]
        begin = time.process_time()
        rows = list[Array]()
        for k in range(count):
            shift = np.zeros(self.size)
            if directions is None:
                shift[k] = difference
            else:
                shift[:] = difference * directions[:, k]
            sides = (self._stepped(integrator, step, side) for side in (shift, -shift))
            rows.append(apart(self.model, *sides))
            if k == 0:
                in_time(self.ends, (count - 1) * (time.process_time() - begin) / SURELY)
        return np.transpose(rows) / (2.0 * difference)

    def _stepped(self, integrator: str, step: float, shift: Array) -> Array:
        """The state a step [s] after a shift of it."""
        in_time(self.ends)
        model = self.model
        data = self.data
        model.opt.timestep, model.opt.integrator = step, kind(integrator)
        put(data, shifted(model, self.state, shift))
        data.qacc_warmstart[:] = self.warm
        mujoco.mj_step(model, data)
        return state_of(data)

    @collected()
    def at_rest(self, integrator: str, step: float) -> TangentMaps | None:
        """Those about a state near by that steps of a size [s] leave as it is, stable or not; None
        where none is found; by Newton's method; a body that nothing holds may be anywhere."""
        maps = self
        before = math.inf
        while True:
            after = maps._stepped(integrator, step, np.zeros(self.size))
            moved = apart(self.model, after, maps.state)
            size = float(np.abs(moved).max())
            if not size < before:
                return None
            if size < AT_REST:
                return maps
            free = np.eye(self.size) - maps(integrator, step, DIFFERENCE)
            if not np.isfinite(free).all():
                return None
            shift = np.asarray(np.linalg.lstsq(free, moved, NEUTRAL)[0], float)
            before = size
            state = shifted(self.model, maps.state, shift)
            maps = TangentMaps(self.model, self.data, state, self.control, self.ends)

    def place(self, weights: Array) -> Place:
        """Where most of the weights of the tangent space, shape (n,), are."""
        put(self.data, self.state)
        mujoco.mj_forward(self.model, self.data)
        return place(self.model, self.data, weights)

    def changed(self, change: Change) -> TangentMaps:
        """Those of the model with a change, about the same state."""
        model = copy.copy(self.model)
        apply(model, (change,))
        return TangentMaps(model, self.data, self.state, self.control, self.ends)


def for_maps(model: Any) -> Any:
    """The model for Jacobians of its steps, changed in place: its solver runs to its floor, and it
    goes on from numbers without bounds."""
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    converging(model).opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_WARMSTART)
    return model


def followed(
    model: Any,
    several: Sequence[Any],
    script: Script,
    begin: int,
    duration: float,
    after: float,
    ends: float = math.inf,
) -> tuple[float, float]:
    """How many times as far apart as a nudge positions of the first and the last of `several`
    mjData are, at most, when `model` has stepped for a `duration` [s] from the nudge of the last
    one; and the largest velocity of a degree of freedom [m/s, rad/s] in the last tenth of its
    steps. Runs from the start of `script` are nudged `after` a time [s], their controls are those
    from the period `begin` on, then the last one. Both are infinite where a run diverges. From the
    processor time `ends` [s] on NotCertifiable is raised."""
    nudge = np.random.default_rng(0).standard_normal(2 * model.nv + model.na)
    nudge *= NUDGE / np.abs(nudge).max()
    for data in several:
        put(data, script.start)
    furthest = 0.0
    rate = 0.0
    step = model.opt.timestep
    nudged = math.ceil(after / step)
    count = nudged + math.ceil(duration / step)
    for k in range(count):
        if k == nudged:
            put(several[-1], shifted(model, state_of(several[-1]), nudge))
        period = int(begin + (k + 1e-6) * step / script.period)
        in_time(ends)
        for data in several:
            data.ctrl[:] = script.controls[min(period, len(script.controls) - 1)]
            mujoco.mj_step(model, data)
        if any(map(diverged, several)):
            return math.inf, math.inf
        between = apart(model, state_of(several[0]), state_of(several[-1]))[: model.nv]
        furthest = max(furthest, float(np.abs(between).max()))
        if k >= count - count // LAST:
            rate = max(rate, float(np.abs(several[0].qvel).max()))
    return furthest / NUDGE, rate
