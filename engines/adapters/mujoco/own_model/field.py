"""The continuous motion of a MuJoCo model: accelerations from the constraint solver, no time step.

The rates of MuJoCo's state are qdot = v (for a quaternion, half its product with the angular
velocity), vdot = qacc and actdot = act_dot. `qacc` comes from the solver, which runs to its floor
without a warm start, so that `qacc` is a function of the state alone.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.terms import put
from plumbob.engines.own_motion import NotCertifiable

MOST_IN_LAYER = 4  # most contacts in a layer: all their 16 on-off states are evaluated
BEYOND = 1e-6  # largest amount by which an activation exceeds its limit: more than rounding
JOINTS = mujoco.mjtJoint
ITERATIONS = 60  # most iterations of Newton's method, which converges in a few
# Times [s] in place of the step, by which the rates of some controls are divided
VANISHING = 2.0**-33
ENDLESS = 2.0**33
# Places of the rates in dynprm
SLEW_RATES = MappingProxyType({"mjDYN_PID": 1, "mjDYN_DCMOTOR": 7})
# Number of coordinates before the quaternion of a joint. Other kinds have one coordinate and no
# quaternion.
STRAIGHT = MappingProxyType({int(JOINTS.mjJNT_FREE): 3, int(JOINTS.mjJNT_BALL): 0})
_FROM_THE_START = int(mujoco.mjtStage.mjSTAGE_NONE)
_AFTER_POSITIONS = int(mujoco.mjtStage.mjSTAGE_POS)


def without_step(model: Any) -> Any:
    """Returns the model, changed in place so that forces do not depend on the step, and the solver
    runs to its floor without a warm start."""
    model.opt.timestep, model.actuator_actearly[:] = VANISHING, False
    return with_converging_solver(model)


def with_converging_solver(model: Any) -> Any:
    """Returns the model, changed in place so that the solver runs to its floor without a warm
    start."""
    option = model.opt
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    # A tolerance of 0 would disable the early exit.
    option.tolerance, option.iterations = 1e-16, ITERATIONS
    option.ls_tolerance, option.ls_iterations = 0.01, 50
    option.ccd_tolerance = min(option.ccd_tolerance, 1e-9)
    option.ccd_iterations = max(option.ccd_iterations, 200)
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_WARMSTART
    return model


class ContinuousField:
    """The rates y' = f(t, y) of a model, y = (qpos, qvel, act), under a control that is held.

    With a layer of `width` [m] a contact begins over that depth: f is the mean over the on-off
    states of the contacts within the layer, weighted by their depths. Its limit for a vanishing
    width is Filippov's sliding motion. A `drive` gives the control at a time [s], in place of the
    control that is held.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        width: float = 0.0,
        drive: Callable[[float], Array] | None = None,
    ) -> None:
        self.model, self.data, self.width, self.drive = model, data, width, drive
        self.places, self.rates = list[int](), list[int]()
        # Places at which a quaternion and its angular velocity begin
        self.quaternions = list[tuple[int, int]]()
        joints = zip(model.jnt_type, model.jnt_qposadr, model.jnt_dofadr, strict=True)
        for joint, q, v in joints:
            straight = STRAIGHT.get(int(joint), 1)
            self.places += range(q, q + straight)
            self.rates += range(v, v + straight)
            if straight != 1:
                self.quaternions.append((int(q) + straight, int(v) + straight))
        # Steps keep an activation at its limit, but the rates do not: there is no motion beyond the
        # limit.
        self.least, self.most = np.full(model.na, -np.inf), np.full(model.na, np.inf)
        for actuator in np.flatnonzero(model.actuator_actlimited):
            last = model.actuator_actadr[actuator] + model.actuator_actnum[actuator] - 1
            self.least[last], self.most[last] = model.actuator_actrange[actuator]
        self.slewing, self.slew_rates = _slewing(model)
        # Time [s] since which the control is held, and the setpoints then
        self.held, self.before = 0.0, np.zeros(self.slewing.size)
        self.targets = self.before

    def __call__(self, t: float, y: Array) -> Array:
        """Returns the rates of a state y of shape (n,) at t [s]. Raises NotCertifiable."""
        model = self.model
        data = self.data
        nq = self.model.nq
        nv = self.model.nv
        self._put(t, y)
        if self.drive is not None:
            data.ctrl[:] = self.drive(t)
        if model.na:
            # The setpoint is computed exactly: its rate ends at once when it arrives, but steps
            # would oscillate there.
            most = self.slew_rates * (t - self.held)
            setpoints = np.clip(self.targets, self.before - most, self.before + most)
            data.act[self.slewing] = setpoints
            if ((data.act < self.least - BEYOND) | (data.act > self.most + BEYOND)).any():
                raise NotCertifiable(f"an activation reaches its limit at {t:.4g} s")
        try:
            acceleration = self._in_layer() if self.width else self._sharp()
        except mujoco.FatalError as error:
            raise NotCertifiable(f"MuJoCo gives it up at {t:.4g} s: {error}") from None
        out = np.empty_like(y)
        speed = y[nq : nq + nv]
        out[self.places] = speed[self.rates]
        for q, v in self.quaternions:
            mujoco.mju_mulQuatAxis(out[q : q + 4], y[q : q + 4], 0.5 * speed[v : v + 3])
        out[nq : nq + nv] = acceleration
        if model.na:
            out[nq + nv :] = data.act_dot
            out[nq + nv + self.slewing] = self.slew_rates * np.sign(self.targets - setpoints)
        return out

    def _put(self, t: float, y: Array) -> None:
        """Sets the state and the time [s]."""
        put(self.data, y)
        self.data.time = t

    def _sharp(self) -> Array:
        """Returns the acceleration with contacts that begin at once."""
        mujoco.mj_forwardSkip(self.model, self.data, _FROM_THE_START, 1)
        self._converged()
        return np.array(self.data.qacc)

    def _in_layer(self) -> Array:
        """Returns the acceleration with contacts that begin over a layer: the weighted mean over
        their on-off states."""
        model = self.model
        data = self.data
        mujoco.mj_fwdPosition(model, data)
        within = []
        for number in range(data.ncon):
            contact = data.contact[number]
            depth = (contact.includemargin - contact.dist) / self.width
            if 0.0 < depth < 1.0 and contact.exclude == 0:
                within.append((number, depth))
        if len(within) > MOST_IN_LAYER:
            raise NotCertifiable(
                f"{len(within)} contacts begin within {self.width:g} m of each other, more than "
                f"{MOST_IN_LAYER}"
            )
        total = np.zeros(model.nv)
        for acting in product((False, True), repeat=len(within)):
            weight = 1.0
            for (number, depth), acts in zip(within, acting, strict=True):
                weight *= depth if acts else 1.0 - depth
                data.contact[number].exclude = 0 if acts else 1
            mujoco.mj_makeConstraint(model, data)
            mujoco.mj_island(model, data)
            mujoco.mj_transmission(model, data)
            mujoco.mj_projectConstraint(model, data)
            mujoco.mj_forwardSkip(model, data, _AFTER_POSITIONS, 1)
            self._converged()
            total += weight * data.qacc
        return total

    def _converged(self) -> None:
        """Raises NotCertifiable if the constraint solver has not converged."""
        data = self.data
        if data.nefc and data.solver_niter[0] >= ITERATIONS:
            raise NotCertifiable(f"the constraint solver stops at {ITERATIONS} iterations")

    def hold(self, control: Array, t: float, y: Array) -> None:
        """Holds a control, shape (actuators,), from the state `y` at `t` [s] on."""
        model = self.model
        data = self.data
        data.ctrl[:] = control
        if self.slewing.size:
            self._put(t, y)
            self.held = t
            self.before = data.act[self.slewing]
            model.opt.timestep = ENDLESS  # any setpoint arrives within this time
            mujoco.mj_forward(model, data)
            model.opt.timestep = VANISHING
            self.targets = self.before + ENDLESS * data.act_dot[self.slewing]

    def normalised(self, y: Array) -> Array:
        """Returns the state with quaternions of length one."""
        scaled = y.copy()
        for q, _ in self.quaternions:
            scaled[q : q + 4] /= np.linalg.norm(scaled[q : q + 4])
        return scaled

    def active(self) -> bytes:
        """Returns bytes that identify the contacts and limits that act in the state of the last
        call, a state that the integration has reached. A change of the bytes is an event."""
        data = self.data
        touching = data.contact.geom.tobytes() if data.ncon else b""
        acting: bytes = data.efc_id.tobytes() + (data.efc_force != 0).tobytes() + touching
        return acting


def _slewing(model: Any) -> tuple[Array, Array]:
    """Returns the activations of `model` that are setpoints of limited rates, and these rates."""
    # A release of MuJoCo may lack a kind of dynamics.
    place_of_rate = {
        int(getattr(mujoco.mjtDyn, name, -1)): place for name, place in SLEW_RATES.items()
    }
    rates = dict[int, float]()
    actuators = zip(
        model.actuator_dyntype, model.actuator_actadr, model.actuator_dynprm, strict=True
    )
    for kind, activation, parameters in actuators:
        if kind in place_of_rate:
            rate = float(parameters[place_of_rate[kind]])
            if rate > 0.0:
                rates[int(activation)] = rate
    return np.array(list(rates), int), np.array(list(rates.values()))
