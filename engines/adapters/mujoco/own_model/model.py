"""A user's own model made ready for an audit: its motion at its own step, and the features that an
audit refuses."""

from __future__ import annotations

import copy
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Signals
from plumbob.engines.adapters.mujoco.colliding_pairs import unmeasured
from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.adapters.mujoco.model_fields import name_of
from plumbob.engines.adapters.mujoco.options import (
    collected,
    disabled,
    integrator_number,
)
from plumbob.engines.adapters.mujoco.own_model import derivatives, left_out, urdf
from plumbob.engines.adapters.mujoco.own_model.corners import corners_of
from plumbob.engines.adapters.mujoco.own_model.field import (
    ContinuousField,
    with_converging_solver,
    without_step,
)
from plumbob.engines.adapters.mujoco.own_model.fields import field_texts
from plumbob.engines.adapters.mujoco.own_model.hidden_touches import HiddenTouches
from plumbob.engines.adapters.mujoco.own_model.jacobian_check import jacobian_note
from plumbob.engines.adapters.mujoco.own_model.places import place_of_weights
from plumbob.engines.adapters.mujoco.own_model.policy import recorded
from plumbob.engines.adapters.mujoco.own_model.readings import (
    control_names,
    held_contacts,
    readings,
    start_warnings,
)
from plumbob.engines.adapters.mujoco.own_model.recorded_steps import (
    MujocoRecordedSteps,
    touching_with_contacts,
)
from plumbob.engines.adapters.mujoco.own_model.refusals import check_continuous
from plumbob.engines.adapters.mujoco.own_model.user_stepper import (
    UserStepper,
    diverged,
    like_start,
)
from plumbob.engines.adapters.mujoco.own_model.variations import batch_states, varied_models
from plumbob.engines.adapters.mujoco.solids import solids
from plumbob.engines.adapters.mujoco.terms import (
    MujocoTerms,
    apart,
    integrator_of,
    put,
    shifted,
    state_of,
)
from plumbob.engines.adapters.mujoco.timed import TimedPeriods
from plumbob.engines.adapters.mujoco.user_file import user_model
from plumbob.engines.drawn_mechanism import DrawnMechanism, drawn_mechanism
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import time_step
from plumbob.engines.own_motion import (
    AS_IT_STANDS,
    AskedPolicy,
    Change,
    HeldContacts,
    ModelVariation,
    MovesData,
    NotCertifiable,
    NotControlled,
    Place,
    Script,
    Start,
    Stepped,
)
from plumbob.engines.peer_model import Layout, ModelJoint
from plumbob.engines.recorded_step import StepInput
from plumbob.engines.stepper import Diverged
from plumbob.models.border import must_be

INTEGRATORS = ("euler", "rk4", "implicit", "implicitfast")
OFFERED = ("euler", "implicitfast", "rk4")  # integrators that a user would try
# Names of integrators in a file; the others are the same there
WRITTEN = MappingProxyType({"euler": "Euler", "rk4": "RK4"})
# Every array of time constants that refsafe raises to two steps, with the stage that uses them, and
# the fields of which one must not be 0 for the constants to act; without a field they always act.
TIME_CONSTANTS = MappingProxyType(
    {
        "geom_solref": ("contact", "geom_contype", "geom_conaffinity"),
        "jnt_solref": ("limit", "jnt_limited"),
        "dof_solref": ("frictionloss", "dof_frictionloss"),
        "eq_solref": ("equality",),
        "pair_solref": ("contact",),
        "pair_solreffriction": ("contact",),
        "tendon_solref_lim": ("limit", "tendon_limited"),
        "tendon_solref_fri": ("frictionloss", "tendon_frictionloss"),
        "flex_solref": ("contact",),
    }
)
COMPARED = int(mujoco.mjtEnableBit.mjENBL_FWDINV)
DISCRETE = int(mujoco.mjtEnableBit.mjENBL_INVDISCRETE)
REFSAFE = int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
SAFE = 2.0  # shortest time constant that refsafe leaves, in steps
SOFTER = 2.0  # factor on time constants that shows whether they act


@dataclass(frozen=True)
class MujocoModel:
    """A user's model, made ready for an audit: its start, and its contacts clamped as the engine
    clamps them at the model's own step."""

    name: str
    effective: Any  # mjModel whose contacts do not depend on the step
    start: Any  # mjData at the start
    step: float
    integrator: str
    integrators: tuple[str, ...]
    steppable: tuple[str, ...]
    clamped: Mapping[str, int]
    notes: tuple[str, ...]
    fields: Mapping[str, str]
    refsafe: bool = True  # whether the file has refsafe on
    # Format of the file. MuJoCo reads options of a URDF file from its element <mujoco>: "urdf" has
    # none, "extended urdf" has one.
    format: str = "mjcf"
    file: Path | None = None  # the file with the model's text; None if there is none
    begin: Start = AS_IT_STANDS  # the start as the user has given it
    drive: Callable[[float], Array] | None = None
    """The control of the continuous motion at a time [s], in place of a script's control."""

    @property
    def bodies(self) -> tuple[str, ...]:
        """The names of the bodies; the number of a body without a name."""
        model = self.effective
        return tuple(name_of(model, "body", body) for body in range(model.nbody))

    @property
    def state(self) -> Array:
        """The state at the start: qpos, qvel, act."""
        return state_of(self.start)

    @property
    def rest(self) -> Array:
        """The controls at the start."""
        return np.array(self.start.ctrl)

    @property
    def ranges(self) -> Array:
        """The ranges of the controls, shape (actuators, 2); NaN for a control without a range."""
        model = self.effective
        limited = np.array(model.actuator_ctrllimited, bool)
        return np.where(limited[:, None], model.actuator_ctrlrange, np.nan)

    def option(self, integrator: str, step: float) -> Mapping[str, tuple[str, str]]:
        """Returns {attribute of the file's options: (its value, its new value)} for another
        integrator and step [s]."""
        now, then = (WRITTEN.get(name, name) for name in (self.integrator, integrator))
        attributes = {
            "timestep": (f"{self.step:.12g}", f"{step:.12g}"),
            "integrator": (now, then),
        }
        return {name: values for name, values in attributes.items() if values[0] != values[1]}

    def softened(self, step: float) -> bool:
        """Whether the engine itself, by refsafe, would soften contacts or limits at a step [s]."""
        return bool(clamped_model(self.as_stepped(), step)[1])

    def softens(self, script: Script, integrator: str, parts: int) -> bool:
        """Returns whether refsafe changes the run of `script` with `parts` steps of an integrator
        in a control period. If nothing touches, refsafe has no effect on the run."""
        step = script.period / parts
        guarded, softened = clamped_model(self.as_stepped(), step)
        return bool(softened) and self._runs_apart(guarded, script, integrator, parts)

    def clamping_acts(self, script: Script) -> bool:
        """Returns whether the time constants that refsafe raises at the model's own step change the
        motion of `script`: softer ones then give another run."""
        if not self.clamped:
            return False
        softer = copy.copy(self.effective)
        for name in set(self.clamped) - {"o_solref"}:
            values = getattr(softer, name)
            values[values[:, 0] == SAFE * self.step, 0] *= SOFTER
        if "o_solref" in self.clamped:
            softer.opt.o_solref[0] *= SOFTER
        parts = script.parts(self.step)
        return self._runs_apart(softer, script, self.integrator, parts)

    def _runs_apart(self, other: Any, script: Script, integrator: str, parts: int) -> bool:
        """Returns whether another compiled model has a run that differs from this model's run."""
        states = self.stepped(script, integrator, parts).states
        changed = replace(self, effective=other).stepped(script, integrator, parts)
        return not np.array_equal(states, changed.states, equal_nan=True)

    def as_stepped(self) -> Any:
        """Returns a copy of `effective`, which has refsafe off, with refsafe on if the file has it
        on."""
        model = copy.copy(self.effective)
        if self.refsafe:
            model.opt.disableflags &= ~REFSAFE
        return model

    @cached_property
    def _shared_models(self) -> tuple[tuple[Any, Any], ...]:
        """The model without sensors for `function_stepper` and for `stepper`, each with its mjData.
        All steppers of a kind share them, as copies of models with textures take long."""
        model = self.as_stepped()
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SENSOR
        models = (with_converging_solver(copy.copy(model)), model)
        return tuple((model, self._new_data(model)) for model in models)

    def stepper(self, integrator: str, step: float) -> UserStepper:
        """Returns a stepper of the model. If the file has refsafe on, contacts are as refsafe makes
        them at each step."""
        return UserStepper(*self._shared_models[1], self.start, integrator, step)

    def function_stepper(self, integrator: str, step: float) -> UserStepper:
        """Returns a stepper whose constraint solver runs to its floor: the state after a step is a
        smooth function of the state before it."""
        return UserStepper(*self._shared_models[0], self.start, integrator, step)

    def recorded_steps(self, integrator: str, step: float) -> MujocoRecordedSteps:
        """Returns single steps [s] of the model by an integrator, each from a given state."""
        return MujocoRecordedSteps(self.as_stepped(), self.start, integrator, step)

    def variations(self) -> Iterator[ModelVariation]:
        """Yields the model with changed settings, each with the model whose motion it should
        have."""
        for name, kind, changed, unchanged in varied_models(self.effective):
            yield ModelVariation(
                name=name,
                kind=kind,
                model=replace(self, effective=changed),
                unchanged=replace(self, effective=unchanged),
            )

    @collected()
    def touching_in(
        self, port: Any, before: StepInput, others: tuple[Any, ...]
    ) -> tuple[Any, ...]:
        """Returns the constraints that are active in a port of the model in a state: its contacts,
        and the constraints of `others` that are no contacts, which are not read from ports."""
        data = self._new_data(self.effective)
        put(data, before.state)
        data.ctrl[:] = before.controls[0]
        port.load(data)
        port.forward()
        port.unload(data)
        return touching_with_contacts(self.effective, data, others)

    @collected()
    def batch(self, states: Array, controls: Array, threads: int) -> Array:
        """Returns the states of runs of the model's own steps in a batch on `threads` threads,
        shape (runs, steps + 1, n), from `states` under controls that all share, shape (steps,
        actuators)."""
        model = self.as_stepped()
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SENSOR
        return batch_states(model, self.start, states, controls, threads)

    @collected()
    def place(self, state: Array, control: Array, weights: Array) -> Place:
        """Returns the joint or activation with most of the `weights` of the tangent space, shape
        (m,), in a state under a control."""
        model, data = self._shared_models[0]
        _evaluate(model, data, state, control)
        return place_of_weights(model, data, weights)

    def field(self, width: float = 0.0) -> ContinuousField:
        """Returns the rates of the continuous motion, with contacts that begin over a layer of
        `width` [m], if given."""
        model = without_step(copy.copy(self.effective))
        return ContinuousField(model, self._new_data(model), width, self.drive)

    def hidden_touches(self, field: ContinuousField, start: Array) -> HiddenTouches:
        """Returns a search for touches within the steps of an integration of a `field` of this
        model from the state `start`."""
        return HiddenTouches(field.model, field.data, self._new_data(field.model), start)

    @property
    def unchecked(self) -> tuple[str, ...]:
        """The kinds of the model's shapes for which touches within a step are not searched."""
        return unmeasured(self.effective)

    @cached_property
    def layout(self) -> Layout:
        """The names of the joints and actuators, and the places of coordinates in a state."""
        model = self.effective
        sizes = np.diff([*model.jnt_dofadr, model.nv]).tolist()
        references = np.split(model.qpos0, model.jnt_qposadr[1:])
        joints = tuple(
            ModelJoint(
                name=model.joint(number).name,
                size=sizes[number],
                position=int(model.jnt_qposadr[number]),
                velocity=int(model.jnt_dofadr[number]),
                reference=references[number],
            )
            for number in range(model.njnt)
        )
        bodies = (model.body(body).name for body in np.flatnonzero(model.body_weldid))
        return Layout(joints, control_names(model), tuple(filter(None, bodies)))

    def mechanism(self) -> Mechanism:
        """Returns the bodies, joints, shapes and actuators, for an engine to build."""
        return compiled_mechanism(self.effective)

    def terms(self) -> MujocoTerms:
        """Returns the terms of the equations of motion, as a function of the state."""
        return MujocoTerms(self.effective, self._new_data(self.effective))

    @collected()
    def stepped(
        self, script: Script, integrator: str, parts: int, single: bool = False
    ) -> Stepped:
        """Returns a run of the model's own steps, `parts` in a control period. If `single`, the
        state is rounded to single precision after each step."""
        model = _with_step(copy.copy(self.effective), integrator, script.period / parts)
        data = self._new_data(model)
        put(data, script.start)
        states = np.full((len(script.controls) + 1, script.start.size), np.nan)
        states[0] = script.start
        controls = np.full_like(script.controls, np.nan, dtype=float)
        why = ""
        capped = 0
        begin = time.thread_time()
        ask = script.new_run()
        for period in range(len(script.controls)):
            end = (period + 1) * script.period
            try:
                data.ctrl[:] = controls[period] = ask(period, states[period])
                _take_steps(model, data, parts, single)
            except mujoco.FatalError as error:
                why = f"ended by MuJoCo within {end:g} s ({error})"
                break
            except NotControlled as reason:
                why = str(reason)
                break
            capped += bool(data.nefc) and data.solver_niter.max() >= model.opt.iterations
            if diverged(data):
                why = f"diverged within {end:g} s"
                break
            states[period + 1] = state_of(data)
        remark = (
            f"the solver stops at its cap of {model.opt.iterations} iterations in {capped} of "
            f"{len(script.controls)} control periods"
        )
        return Stepped(
            step=model.opt.timestep,
            states=states,
            seconds=time.thread_time() - begin,
            why=why,
            remarks=(remark,) if capped else (),
            controls=controls,
        )

    def timed(
        self, script: Script, states: Array, integrator: str, parts: int, steps: int
    ) -> TimedPeriods:
        """Returns steps to be timed: the first `steps` of `parts` in each period of `script`. A
        period begins at its row of `states`, or where the last period ended if the row is NaN."""
        model = _with_step(copy.copy(self.effective), integrator, script.period / parts)
        return TimedPeriods(model, self._new_data(model), states, script.controls, steps)

    def moving_data(self, integrator: str, period: float, parts: int) -> MovesData:
        """Returns a function that moves an mjData with this model's sizes, such as an
        environment's, through a control period [s] by `parts` steps of an integrator."""
        model = _with_step(copy.copy(self.effective), integrator, period / parts)

        def move(data: Any, control: Array) -> None:
            """Moves an mjData under controls, shape (actuators,). Raises Diverged."""
            data.ctrl[:] = control
            mujoco.mj_step(model, data, parts)
            # An environment also reads the forces of contacts.
            mujoco.mj_rnePostConstraint(model, data)
            if diverged(data):
                raise Diverged(f"diverged at {data.time:.4g} s")

        return move

    def place_data(self, data: Any, state: Array) -> None:
        """Puts an mjData with this model's sizes into a state, of which all that an environment
        reads is computed anew."""
        put(data, state)
        mujoco.mj_forward(self.effective, data)
        mujoco.mj_rnePostConstraint(self.effective, data)

    def recorded(self, loop: AskedPolicy, period: float, duration: float) -> Array:
        """Returns the controls that a policy gives to a run at the model's own step over a duration
        [s], shape (periods, actuators). The policy is asked at the begin of each period [s]. Raises
        ParameterError and NotControlled."""
        return recorded(self.effective, copy.copy(self.start), loop, period, duration)

    def changes(self, script: Script) -> tuple[Change, ...]:
        """Returns features to remove, each to be tried, chosen from the model's own steps under
        `script`."""
        with collected():
            met = set[tuple[int, ...]]()
            for data in self._data_after_steps(script):
                met |= {tuple(sorted(pair)) for pair in data.contact.geom.tolist()}
        return tuple(left_out.removable_features(self.effective, met))

    def touched(self, script: Script) -> Iterator[tuple[int, Array]]:
        """Yields the periods and states of the model's own steps at which something touches."""
        with collected():
            for data in self._data_after_steps(script):
                if data.contact.dist.min(initial=1.0) <= 0.0:
                    period = min(int(data.time / script.period), len(script.controls) - 1)
                    yield period, state_of(data)

    def _data_after_steps(self, script: Script) -> Iterator[Any]:
        """Yields the mjData after each of the model's own steps. The contacts in it are those at
        the beginning of the step."""
        model = copy.copy(self.effective)
        data = self._new_data(model)
        put(data, script.start)
        for control in script.controls:
            data.ctrl[:] = control
            for _ in range(script.parts(self.step)):
                mujoco.mj_step(model, data)
                if diverged(data):
                    return
                yield data

    def changed(self, changes: Sequence[Change]) -> MujocoModel:
        """Returns the model with changes."""
        model = copy.copy(self.effective)
        left_out.apply(model, changes)
        return replace(self, effective=model)

    def with_integrators(self, integrators: tuple[str, ...]) -> MujocoModel:
        """Returns the model with the first of some integrators as its own, and only these to try in
        a search for the largest step."""
        return replace(self, integrator=integrators[0], steppable=integrators)

    def _new_data(self, model: Any) -> Any:
        """Returns new mjData of `model` with the mocap poses and the active constraints of the
        start; positions and velocities are those of the drawing."""
        return like_start(mujoco.MjData(model), self.start)

    @cached_property
    def _corners(self) -> tuple[Array, Array]:
        """The corner points of the bodies in their own frames [m], shape (corners, 3), and the body
        of each corner."""
        return corners_of(self.effective)

    @property
    def corner_bodies(self) -> Array:
        """The body of each corner point, shape (corners,)."""
        return self._corners[1]

    def corners(self, states: Array) -> Array:
        """Returns corner points of the bodies [m], shape (len(states), corners, 3). The largest
        displacement of a corner is the error of its body, so that its rotation counts, too."""
        data = self._new_data(self.effective)
        offsets, bodies = self._corners
        places = np.full((len(states), len(bodies), 3), np.nan)
        for number in self._placed(states, data):
            turns = data.xmat.reshape(-1, 3, 3)[bodies]
            places[number] = data.xpos[bodies] + np.einsum("kij,kj->ki", turns, offsets)
        return places

    def _placed(self, states: Array, data: Any) -> Iterator[int]:
        """Puts the bodies to their places in each finite state, and yields the state's number."""
        model = self.effective
        for number, state in enumerate(states):
            if np.isfinite(state[: model.nq]).all():
                data.qpos[:] = state[: model.nq]
                mujoco.mj_kinematics(model, data)
                yield number

    def poses(self, states: Array) -> Array:
        """Returns the centres of mass of the bodies [m] and their attitudes as quaternions, scalar
        first, shape (len(states), bodies, 7)."""
        model = self.effective
        data = self._new_data(self.effective)
        poses = np.full((len(states), model.nbody, 7), np.nan)
        for number in self._placed(states, data):
            mujoco.mj_comPos(model, data)
            poses[number] = np.hstack([data.xipos, data.xquat])
        return poses

    @property
    def drawn(self) -> DrawnMechanism:
        """The bodies, joints and geoms of the model, as a replay draws them."""
        return drawn_mechanism(self.mechanism(), tuple(solids(self.effective, self.start)))

    def readings(self, states: Array) -> Signals:
        """Returns {name: values of shape (len(states),)} of the energy [J] and of violations of
        contacts, limits and equalities [m or rad], without those that the model cannot have."""
        return readings(self.effective, self._new_data(self.effective), states)

    @collected()
    def held_contacts(self, state: Array, control: Array) -> HeldContacts:
        """Returns the depth and the drift of the contacts of a state that friction should hold."""
        data = self._new_data(self.effective)
        _evaluate(self.effective, data, state, control)
        return held_contacts(self.effective, data)

    @property
    def names(self) -> Mapping[str, tuple[str, ...]]:
        """{kind: names of the numbers of that kind} on which a motion depends. The kinds are
        "position", "velocity" and "activation" of the start, in its tangent space, and
        "control"."""
        return derivatives.names(self.effective)

    def shifted(self, state: Array, shift: Array) -> Array:
        """Returns a state moved by a shift of positions, velocities and activations in the tangent
        space."""
        return shifted(self.effective, state, shift)

    @property
    def activations(self) -> slice:
        """The slice of a state that holds the activations."""
        return slice(self.effective.nq + self.effective.nv, None)

    def coordinates(self, states: Array, others: Array) -> Array:
        """Returns the differences of two motions in generalised coordinates [rad or m], shape
        (len(states), degrees of freedom)."""
        model = self.effective
        pairs = zip(states, others, strict=True)
        return np.array([apart(model, state, other)[: model.nv] for state, other in pairs])


def _take_steps(model: Any, data: Any, steps: int, single: bool) -> None:
    """Takes `steps` steps. If `single`, the state is rounded to single precision after each."""
    if not single:
        mujoco.mj_step(model, data, steps)
        return
    for _ in range(steps):
        mujoco.mj_step(model, data)
        put(data, state_of(data).astype("f4"))


def _evaluate(model: Any, data: Any, state: Array, control: Array) -> None:
    """Computes all terms and constraints of a state under a control in `data`."""
    put(data, state)
    data.ctrl[:] = control
    mujoco.mj_forward(model, data)


def _with_step(model: Any, integrator: str, step: float) -> Any:
    """Returns the model with an integrator and a step [s], changed in place."""
    model.opt.timestep, model.opt.integrator = step, integrator_number(integrator)
    return model


def own_model(model: Any, name: str, start: Start = AS_IT_STANDS) -> MujocoModel:
    """Returns the compiled `model` made ready for an audit, from its `start`. Raises ParameterError
    for a start that is not possible, and NotCertifiable for features that no audit can follow."""
    model = copy.copy(model)
    step = time_step("model", model.opt.timestep, name)
    check_continuous(model)
    data = start_data(model, start)
    numbers = (data.qpos, data.qvel, data.act, data.xipos, data.qacc)
    if not all(np.isfinite(values).all() for values in numbers):
        raise NotCertifiable("at its start something is not a number")
    effective, clamped = clamped_model(model, step)
    # Steps from NaN take a thousand times as long: a model that diverges is reset, and MuJoCo's
    # warnings show that.
    effective.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    # This check of MuJoCo's takes time and does not change the motion.
    effective.opt.enableflags &= ~COMPARED
    integrator = integrator_of(model)
    if integrator not in INTEGRATORS:
        raise NotCertifiable(f"its integrator is {integrator}")
    refusals = _refusals(model)
    if integrator in refusals:
        raise NotCertifiable(refusals[integrator])
    remarks = (f"{other} is not tried: {why}" for other, why in refusals.items())
    own_first = dict.fromkeys((integrator, *INTEGRATORS))
    steppable = tuple(other for other in own_first if other not in refusals)
    return MujocoModel(
        name=name,
        effective=effective,
        start=data,
        step=step,
        integrator=integrator,
        integrators=tuple(
            other for other in dict.fromkeys((integrator, *OFFERED)) if other in steppable
        ),
        steppable=steppable,
        clamped=clamped,
        notes=(*_notes(model, data), *remarks),
        fields=field_texts(model),
        refsafe=not model.opt.disableflags & REFSAFE,
    )


def model_of_own(model: Any, start: Start) -> MujocoModel:
    """Returns a user's model, from a file, compiled or with its data, made ready for an audit.
    Raises ParameterError and NotCertifiable."""
    ready = own_model(*user_model(model, start))
    if isinstance(model, (str, Path)) and Path(model).suffix != ".mjb":
        path = Path(model)
        notes = (*ready.notes, *urdf.urdf_notes(path))
        file_format = urdf.file_format(path)
        return replace(ready, notes=notes, format=file_format, file=path.resolve(), begin=start)
    return ready


def start_data(model: Any, start: Start = AS_IT_STANDS) -> Any:
    """Returns the mjData of the compiled `model` at its `start`, with all positions computed.
    Raises ParameterError, and NotCertifiable if MuJoCo refuses the start."""
    data = mujoco.MjData(model)
    if start.keyframe is not None:
        mujoco.mj_resetDataKeyframe(model, data, _keyframe(model, start.keyframe))
    for name, values in (("qpos", start.qpos), ("qvel", start.qvel)):
        if values is None:
            continue
        state = getattr(data, name)
        shown: Any = values if isinstance(values, str) else type(values).__name__
        with must_be("a list of numbers", name, shown):
            numbers = np.asarray(values, dtype=float)
        if numbers.shape != state.shape or not np.isfinite(numbers).all():
            shown = f"{numbers.size} numbers" if numbers.size != state.size else values
            raise ParameterError(name, shown, f"{state.size} finite numbers, as the model has")
        state[:] = numbers
    try:
        mujoco.mj_forward(model, data)
    except mujoco.FatalError as error:
        raise NotCertifiable(f"MuJoCo refuses it: {error}") from None
    return data


def _refusals(model: Any) -> Mapping[str, str]:
    """Returns {integrator: the reason} for the integrators with which MuJoCo does not step the
    compiled `model`."""
    reasons = {integrator: _refusal(model, integrator) for integrator in INTEGRATORS}
    return {integrator: why for integrator, why in reasons.items() if why}


def _refusal(model: Any, integrator: str) -> str:
    """Explains why MuJoCo does not step the compiled `model` with an integrator; empty if it
    does."""
    flags = model.opt.enableflags
    if integrator == "rk4" and flags & COMPARED and flags & DISCRETE:
        return "MuJoCo compares it with inverse dynamics in discrete time (fwdinv, invdiscrete)"
    other = copy.copy(model)
    other.opt.integrator = integrator_number(integrator)
    try:
        start_data(other)
    except NotCertifiable as why:
        return str(why)
    return ""


def clamped_model(model: Any, step: float) -> tuple[Any, Mapping[str, int]]:
    """Returns a copy of a model in which time constants are raised as refsafe raises them at `step`
    [s], and {array of time constants: number of raised ones that act}. refsafe itself is off in the
    copy, so that the motion of the copy does not depend on the step."""
    model = copy.copy(model)
    changed: dict[str, int] = {}
    if model.opt.disableflags & REFSAFE:
        return model, changed
    least = SAFE * step
    disabled_stages = set(disabled(model.opt.disableflags))
    for name, (stage, *switches) in TIME_CONSTANTS.items():
        values = getattr(model, name, np.zeros((0, 2)))
        short = (values[:, 0] > 0.0) & (values[:, 0] < least)
        values[short, 0] = least
        acting = [getattr(model, switch) != 0 for switch in switches] or [short]
        acting_count = int((short & np.any(acting, axis=0)).sum())
        if acting_count and not disabled_stages & {"constraint", stage}:
            changed[name] = acting_count
    overriding = model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_OVERRIDE
    if overriding and 0.0 < model.opt.o_solref[0] < least:
        model.opt.o_solref[0], changed["o_solref"] = least, 1
    model.opt.disableflags |= REFSAFE
    return model, changed


def _keyframe(model: Any, keyframe: int | str) -> int:
    """Returns the number of a keyframe, given by name or number. Raises ParameterError."""
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, str(keyframe))
    if number < 0 and str(keyframe).isdecimal():
        number = int(keyframe)
    if 0 <= number < model.nkey:
        return int(number)
    names = (model.key(key).name or str(key) for key in range(model.nkey))
    offered = ", ".join(names) or "none: the model has none"
    raise ParameterError("keyframe", keyframe, f"one of {offered}")


def _notes(model: Any, start: Any) -> tuple[str, ...]:
    """Returns remarks on disabled stages and on an unlikely `start`."""
    stages = ", ".join(disabled(model.opt.disableflags))
    notes = [f"disabled: {stages}"] if stages else []
    wrong_solver = jacobian_note(model, start)
    return (*notes, *([wrong_solver] if wrong_solver else ()), *start_warnings(start))
