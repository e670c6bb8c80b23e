"""Derivatives of the end of a run: step derivatives by `mjd_transitionFD` or `mjd_inverseFD`,
multiplied along the run.

The state x, in tangent coordinates, follows x_n+1 = f(x_n, u_n) under the controls u. With A = f_x
and B = f_u by MuJoCo's central differences, the derivative by a parameter p of the start or of the
controls follows

    dx_n+1/dp = A_n dx_n/dp + B_n du_n/dp.                                                      (1)

Rounding of the differences is some units in the last place of a state over STEP_NUDGE in each step.
The differences of another size, BESIDE, tell how much that makes in all. With contacts the
differences have the size TOUCHING_NUDGE: in the step in which a support begins to slip, its speed
is less than STEP_NUDGE, so that a difference of that size would reverse its friction. On
capsule-turn/pivot at 0.15 to 1 ms the product is then within 1e-4 of the run's derivative; with
STEP_NUDGE it is up to 5e-3 away from it. Implicit integrators keep STEP_NUDGE: they take the
velocity from contact forces, whose rounding is 1e4 times that of an acceleration.

Without contacts the acceleration a of a step solves the inverse dynamics g(q, v, a) = 0, so that

    da = -(dg/da)^-1 (dg/dq dq + dg/dv dv)                                                      (2)

moves the velocity. `mjd_inverseFD` takes forward differences, whose error is proportional to their
size; the mean of differences by STEP_NUDGE and by -STEP_NUDGE removes it. The function g is linear
in a."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

import mujoco
import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.simulation import MujocoSimulation, compiled
from plumbob.engines.adapters.mujoco.terms import apart, put, shifted, state_of
from plumbob.engines.adapters.own_derivatives import moved, nudged
from plumbob.engines.derivative_ways import STEP_NUDGE, TOUCHING_NUDGE, product_of_steps
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.trajectory import ByName
from plumbob.models.gradient import Number

# Factor from a size of differences to the other size, which tells their rounding
BESIDE = MappingProxyType({STEP_NUDGE: 10.0, TOUCHING_NUDGE: 0.5})


def difference_size(model: mujoco.MjModel) -> float:
    """The size of central differences for a model's step."""
    touching = model.npair or model.geom_contype.any() or model.geom_conaffinity.any()
    return TOUCHING_NUDGE if touching else STEP_NUDGE


@dataclass(frozen=True)
class Sides:
    """Three runs: with a number a little smaller, unchanged, and a little larger."""

    runs: tuple[MujocoSimulation, ...]
    apart: float  # difference of the number between the outer runs

    @property
    def by_model(self) -> bool:
        """Whether the number belongs to the model, and not only to the start or the controls."""
        return len({_numbers(run.model) for run in self.runs}) > 1

    @property
    def controls(self) -> tuple[Array, Array]:
        """The controls of each step, and their derivatives by the number, shape (steps, nu)
        each."""
        low, middle, high = (
            run.held_controls(np.arange(float(run.steps)), run.step) for run in self.runs
        )
        return middle, (high - low) / self.apart

    def at_start(self) -> Array:
        """Puts the middle run at its start, and returns the derivative of the start by the number,
        in tangent coordinates."""
        _, run, _ = self.runs
        mujoco.mj_resetData(run.model, run.data)
        translations = [side.translation for side in self.runs]
        low, middle, high = (
            np.concatenate([start.qpos, start.qvel, run.data.act]) for start in translations
        )
        put(run.data, middle)
        return apart(run.model, high, low) / self.apart

    def read(self, along: Array) -> ByName:
        """The total derivatives of the observables at the present state of the middle run. The
        state has the derivative `along`, a tangent; a further part is the change of the
        observables of one state, as the low and the high run read it."""
        low, middle, high = self.runs
        model = middle.model
        state = state_of(middle.data)

        def observe(place: float, rate: float, run: MujocoSimulation = middle) -> Signals:
            """The observables of the end, moved along its tangent by two amounts, as `run` reads
            them."""
            amounts = np.repeat([place, rate, 0.0], [model.nv, model.nv, model.na])
            end = shifted(model, state, along * amounts)[None]
            qpos, qvel, _ = np.split(end, (model.nq, model.nq + model.nv), axis=1)
            return run.translation.observed(qpos, qvel)[0]

        # The outer cases may read the same state otherwise.
        read_low, read_high = (observe(0.0, 0.0, run) for run in (low, high))
        derivatives = dict(moved(observe, *along[: 2 * model.nv].reshape(2, -1)))
        for name in derivatives:
            derivatives[name] += float(read_high[name][0] - read_low[name][0]) / self.apart
        return derivatives


def transition(number: Number, method: Method, step: float, beside: bool = False) -> ByName:
    """The derivatives of the observables at the end of a run by eq. 1; raises Unsupported. If
    `beside`, the differences have the other size, which tells their rounding."""
    sides = _sides(number, method, step)
    if sides.by_model:
        raise Unsupported(
            f"mjd_transitionFD has derivatives by state and control: {number.name} "
            "is a parameter of the model"
        )
    run = sides.runs[1]
    along = sides.at_start()
    by_forces = run.model.opt.integrator != mujoco.mjtIntegrator.mjINT_EULER
    nudge = STEP_NUDGE if by_forces else difference_size(run.model)
    if beside:
        nudge *= BESIDE[nudge]
    with options.collected():  # the run itself gives the same warnings
        controls, changes = sides.controls
        steps = run.stepper.derivatives_of_steps(controls, nudge)
        *_, along = product_of_steps(steps, along, changes)
        return sides.read(along)


def inverse(number: Number, method: Method, step: float, beside: bool = False) -> ByName:
    """The derivatives of the observables at the end of a run by eq. 2; raises Unsupported. If
    `beside`, the differences have the other size."""
    sides = _sides(number, method, step)
    model = sides.runs[1].model
    data = sides.runs[1].data
    if model.ngeom or model.dof_frictionloss.any():
        raise Unsupported(
            "mjd_inverseFD has differences of accelerations that are too large for friction"
        )
    controls, changes = sides.controls
    if sides.by_model or changes.any():
        raise Unsupported(
            f"mjd_inverseFD has derivatives by the state alone, not by {number.name}"
        )
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_INVDISCRETE
    along = sides.at_start()
    # Views of the parts of the derivative, which `_step_ahead` changes
    along_qpos, along_qvel = along[: 2 * model.nv].reshape(2, -1)
    before = mujoco.MjData(model)
    nudge = STEP_NUDGE * BESIDE[STEP_NUDGE] if beside else STEP_NUDGE
    with options.collected():
        for control in controls:
            put(before, state_of(data))
            before.ctrl[:] = data.ctrl[:] = control
            mujoco.mj_step(model, data)
            _step_ahead(model, before, data.qvel, (along_qpos, along_qvel), nudge)
        return sides.read(along)


def _step_ahead(
    model: mujoco.MjModel,
    before: mujoco.MjData,
    after: Array,
    along: tuple[Array, Array],
    nudge: float,
) -> None:
    """Moves a derivative in place from the state `before` a step to the step's end, where the
    velocity is `after`, by eq. 2. `along` are the derivatives of the positions and of the
    velocities, shape (nv,) each. Differences have the size `nudge`."""
    places, rates = along
    step = model.opt.timestep
    before.qacc[:] = (after - before.qvel) / step
    # Derivatives of the forces by qpos and by qvel, from differences of either sign
    by_state = np.zeros((2, 2, model.nv, model.nv))
    mass = np.zeros((model.nv,) * 2)
    for eps, matrices in zip((nudge, -nudge), by_state, strict=True):
        mujoco.mjd_inverseFD(model, before, eps, True, *matrices, *[None] * 5)
    # The forces are linear in the accelerations, and a nudge would be lost beside 1e6 rad/s^2.
    size = 1.0 + float(np.abs(before.qacc).max())
    mujoco.mjd_inverseFD(model, before, size, True, None, None, mass, *[None] * 4)
    by_place, by_rate = by_state.mean(axis=0).transpose(0, 2, 1)
    rates -= step * np.linalg.solve(mass.T, by_place @ places + by_rate @ rates)
    ends = before.qpos.copy(), before.qpos.copy()
    for side, end in zip((-nudge, nudge), ends, strict=True):
        mujoco.mj_integratePos(model, end, places, side)
        mujoco.mj_integratePos(model, end, after + side * rates, step)
    mujoco.mj_differentiatePos(model, places, 2 * nudge, *ends)


def _sides(number: Number, method: Method, step: float) -> Sides:
    """The runs with a number on both sides of its value; raises Unsupported."""
    cases, apart = nudged(number)
    sides = Sides(tuple(compiled(case, method, step) for case in cases), apart)
    if sides.runs[1].model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        raise Unsupported("mjd_transitionFD and mjd_inverseFD refuse RK4")
    return sides


def _numbers(model: mujoco.MjModel) -> bytes:
    """All numbers of a model, without its keyframes, as bytes."""
    binary = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    model.key_qpos[:], model.key_qvel[:] = 0.0, 0.0
    mujoco.mj_saveModel(model, None, binary)
    return binary.tobytes()
