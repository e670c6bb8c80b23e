"""Single steps of a user's model from recorded states: as the model takes them, with a solver that
converges, with nudged inputs, and with a part of the model changed."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.model_fields import name_with_kind
from plumbob.engines.adapters.mujoco.options import collected, integrator_number
from plumbob.engines.adapters.mujoco.own_model.field import with_converging_solver
from plumbob.engines.adapters.mujoco.own_model.left_out import NEVER
from plumbob.engines.adapters.mujoco.own_model.readings import pair_name
from plumbob.engines.adapters.mujoco.own_model.user_stepper import diverged, like_start
from plumbob.engines.adapters.mujoco.terms import apart, put, state_of
from plumbob.engines.recorded_step import RecordedRun, StepInput, StepOutcome, Suspect

# Numbers of a model that a step computes with: those of its mass matrix, of its forces, and of the
# places of its shapes
NUDGED_FIELDS = (
    *("body_pos", "body_quat", "body_ipos", "body_iquat", "body_mass", "body_inertia"),
    *("jnt_pos", "jnt_axis", "jnt_stiffness", "qpos_spring", "dof_armature", "dof_damping"),
    *("dof_invweight0", "body_invweight0"),
    *("geom_pos", "geom_quat", "geom_size", "geom_friction"),
    *("actuator_gear", "actuator_gainprm", "actuator_biasprm", "tendon_stiffness"),
    *("tendon_damping",),
)
FIRST_LIMIT = int(mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT)
FIRST_CONTACT = int(mujoco.mjtConstraint.mjCNSTR_CONTACT_FRICTIONLESS)
NUDGES = 8  # sets of nudges: their root mean square is within a factor of 2 of that of all sets
NUDGED_FORCES = ("qfrc_bias", "qfrc_passive", "qfrc_actuator", "qfrc_constraint")
# Fields of one joint's degrees of freedom, of joints and of bodies that a suspect scales
DOF_FIELDS = MappingProxyType(
    {"damping": "dof_damping", "armature": "dof_armature", "friction loss": "dof_frictionloss"}
)


def unit_in_last_place(values: Array, precision: type[np.floating[Any]]) -> Array:
    """Returns the distance of each value to the next number of a precision; 0 for a value of 0."""
    spacing = np.spacing(np.abs(values).astype(precision)).astype(float)
    return np.where(values == 0.0, 0.0, spacing)


class MujocoRecordedSteps:
    """Steps of a compiled model at a time step [s] by an integrator, each from a given state."""

    def __init__(self, model: Any, start: Any, integrator: str, step: float) -> None:
        """Takes the mocap poses and the active constraints of the mjData `start`."""
        self.model = copy.copy(model)
        self.model.opt.timestep, self.model.opt.integrator = step, integrator_number(integrator)
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SENSOR
        self.start = start
        self.data = self._new_data(self.model)
        self._nudges: dict[Any, list[dict[str, Array]]] = {}

    @cached_property
    def converging(self) -> Any:
        """The model with a solver that runs to its floor."""
        return with_converging_solver(copy.copy(self.model))

    @cached_property
    def changed(self) -> Any:
        """A copy of the model whose numbers are changed for some steps."""
        return copy.copy(self.model)

    @cached_property
    def changed_converging(self) -> Any:
        """A copy of the model with a solver that runs to its floor, for nudges."""
        return copy.copy(self.converging)

    @cached_property
    def changed_data(self) -> Any:
        """The mjData of the changed copy."""
        return self._new_data(self.changed)

    def _new_data(self, model: Any) -> Any:
        """Returns new mjData of `model` with the mocap poses of the start."""
        return like_start(mujoco.MjData(model), self.start)

    @collected()
    def _after(self, model: Any, data: Any, before: StepInput, force: Any = 0.0) -> StepOutcome:
        """Returns the outcome of steps of `model` under a generalised `force`."""
        self._begin(model, data, before)
        data.qfrc_applied[:] = force
        touching: tuple[Any, ...] = ()
        for number, control in enumerate(before.controls):
            data.ctrl[:] = control
            try:
                mujoco.mj_step(model, data)
            except mujoco.FatalError:
                return StepOutcome(np.full(before.state.size, np.nan), before.warm_start, ())
            touching = touching if number else _touching(data)
        iterations = int(data.solver_niter.max()) if data.nefc else 0
        return StepOutcome(state_of(data), np.array(data.qacc_warmstart), touching, iterations)

    def _begin(self, model: Any, data: Any, before: StepInput) -> None:
        """Puts the mjData of `model` into the state before steps."""
        mujoco.mj_resetData(model, data)
        like_start(data, self.start)
        put(data, before.state)
        data.qacc_warmstart[:] = before.warm_start

    @property
    def most_iterations(self) -> int:
        """The cap on the iterations of the solver."""
        return int(self.model.opt.iterations)

    @collected()
    def run(self, before: StepInput) -> RecordedRun:
        """Returns the run of all steps of `before`, in new mjData. It ends early if it diverges."""
        data = self._new_data(self.model)
        self._begin(self.model, data, before)
        states, warm_starts = [before.state], [before.warm_start]
        for control in before.controls:
            data.ctrl[:] = control
            try:
                mujoco.mj_step(self.model, data)
            except mujoco.FatalError:
                break
            if diverged(data):
                break
            states.append(state_of(data))
            warm_starts.append(np.array(data.qacc_warmstart))
        return RecordedRun(np.array(states), np.array(warm_starts))

    def after(self, before: StepInput) -> StepOutcome:
        """Returns the outcome of the model's own steps."""
        return self._after(self.model, self.data, before)

    def converged(self, before: StepInput) -> StepOutcome:
        """Returns the outcome of steps whose constraint solver runs to its floor."""
        return self._after(self.converging, self.data, before)

    def nudged(
        self,
        before: StepInput,
        precision: type[np.floating[Any]],
        stored: Callable[[Array], Array],
        converged: bool = False,
    ) -> Array:
        """Returns the changes of the state after the steps, in tangent coordinates, shape (NUDGES,
        m), if the state, the controls, the forces and the numbers of the model change by a unit in
        the last place of a precision. State and controls change by `stored` of their values if that
        is more. If `converged`, the solver runs to its floor."""
        model = self.model
        outcome = self._after(self.converging if converged else model, self.data, before)
        largest = sum(np.abs(getattr(self.data, name)) for name in NUDGED_FORCES)
        unit = unit_in_last_place(np.asarray(largest), precision)
        rng = np.random.default_rng(0)

        def moved(values: Array, least: Callable[[Array], Array] | None = None) -> Array:
            """Returns values a unit in the last place up or down, or `least` of them if that is
            more."""
            size = unit_in_last_place(values, precision)
            if least is not None:
                size = np.maximum(size, least(values))
            return np.asarray(values + rng.choice([-1.0, 1.0], values.shape) * size)

        other = self.changed_converging if converged else self.changed
        changes = np.empty((NUDGES, 2 * model.nv + model.na))
        for number, numbers in enumerate(self._nudged_numbers(precision)):
            _set_fields(other, numbers)
            nudged = StepInput(
                moved(before.state, stored),
                moved(before.controls, stored),
                moved(before.warm_start),
            )
            force = rng.choice([-1.0, 1.0], model.nv) * unit
            after = self._after(other, self.changed_data, nudged, force)
            changes[number] = apart(model, after.state, outcome.state)
        self._restore()
        return changes

    def _nudged_numbers(self, precision: type[np.floating[Any]]) -> list[dict[str, Array]]:
        """Returns NUDGES sets of the model's numbers, each changed by a unit in the last place."""
        if precision not in self._nudges:
            rng = np.random.default_rng(1)
            fields = {name: np.array(getattr(self.model, name)) for name in NUDGED_FIELDS}
            self._nudges[precision] = [
                {
                    name: values
                    + rng.choice([-1.0, 1.0], values.shape)
                    * unit_in_last_place(values, precision)
                    for name, values in fields.items()
                }
                for _ in range(NUDGES)
            ]
        return self._nudges[precision]

    def _restore(self) -> None:
        """Gives the changed model the numbers of the model again."""
        fields = (*NUDGED_FIELDS, *DOF_FIELDS.values(), "geom_contype", "geom_conaffinity")
        _set_fields(self.changed, {name: getattr(self.model, name) for name in fields})
        self.changed.pair_margin[:] = self.model.pair_margin
        self.changed.opt.gravity = self.model.opt.gravity

    def touching(self, state: Array) -> tuple[Any, ...]:
        """Returns the constraints that are active in a state: contacts, limits and others."""
        with collected():
            put(self.data, state)
            mujoco.mj_fwdPosition(self.model, self.data)
            return _touching(self.data)

    def names_of(self, touching: tuple[Any, ...]) -> tuple[str, ...]:
        """Returns the names of the contacts and limits in the result of `touching`."""
        return tuple(dict.fromkeys(self._name_of(*entry) for entry in touching))

    def _name_of(self, kind: int, number: int, geoms: tuple[int, ...]) -> str:
        """Returns the name of a constraint by its kind, its number and its geoms."""
        if geoms:
            return f"contact {pair_name(self.model, geoms)}"
        if kind == FIRST_LIMIT:
            return f"limit of {name_with_kind(self.model, 'joint', number)}"
        words = str(mujoco.mjtConstraint(kind).name).removeprefix("mjCNSTR_")
        return words.lower().replace("_", " ")

    def without_contact(self, before: StepInput, pair: tuple[int, ...]) -> StepOutcome:
        """Returns the outcome of steps without the collisions of the moving geom of a pair, or of
        the pair that the file declares."""
        moving = [geom for geom in pair if self.model.body_weldid[self.model.geom_bodyid[geom]]]
        geom = (moving or list(pair))[0]
        self.changed.geom_contype[geom] = self.changed.geom_conaffinity[geom] = 0
        declared = (self.model.pair_geom1 == geom) | (self.model.pair_geom2 == geom)
        self.changed.pair_margin[declared] = NEVER
        outcome = self._after(self.changed, self.changed_data, before)
        self._restore()
        return outcome

    def suspects(self) -> Iterator[Suspect]:
        """Yields parts of the model that a changed factor on their numbers may explain: gravity,
        masses, actuators, friction, and the damping, stiffness, armature and friction loss of
        joints."""
        model = self.model

        def scaled(field: str, index: Any, factor: float) -> None:
            """Multiplies numbers of a field of the changed model."""
            numbers = getattr(self.changed, field)
            numbers[index] = factor * getattr(model, field)[index]

        def gravity(factor: float) -> None:
            """Multiplies the gravity of the changed model."""
            self.changed.opt.gravity[:] = factor * model.opt.gravity

        def mass(body: int, factor: float) -> None:
            """Multiplies the mass and the inertia of a body of the changed model."""
            scaled("body_mass", body, factor)
            scaled("body_inertia", body, factor)

        yield self._suspect("gravity", gravity)
        for body in range(1, model.nbody):
            if model.body_mass[body] > 0.0:
                name = f"mass of {name_with_kind(model, 'body', body)}"
                yield self._suspect(name, partial(mass, body))
        for actuator in range(len(model.actuator_gear)):
            name = f"gear of {name_with_kind(model, 'actuator', actuator)}"
            yield self._suspect(name, partial(scaled, "actuator_gear", actuator))
        for joint in range(model.njnt):
            name = name_with_kind(model, "joint", joint)
            if model.jnt_stiffness[joint]:
                stiffness = partial(scaled, "jnt_stiffness", joint)
                yield self._suspect(f"stiffness of {name}", stiffness)
            degrees = np.flatnonzero(model.dof_jntid == joint)
            for what, field in DOF_FIELDS.items():
                if getattr(model, field)[degrees].any():
                    yield self._suspect(f"{what} of {name}", partial(scaled, field, degrees))
        if model.ngeom:
            everywhere = partial(scaled, "geom_friction", slice(None))
            yield self._suspect("friction of contacts", everywhere)

    def _suspect(self, name: str, change: Callable[[float], None]) -> Suspect:
        """Returns a part of the model whose numbers `change` multiplies by a factor."""

        def after(before: StepInput, factor: float) -> StepOutcome:
            """Returns the outcome of steps with the numbers of the part times a factor."""
            change(factor)
            outcome = self._after(self.changed, self.changed_data, before)
            self._restore()
            return outcome

        return Suspect(name, after)

    @property
    def place_names(self) -> tuple[str, ...]:
        """The joint of each degree of freedom."""
        joints = self.model.dof_jntid.tolist()
        return tuple(name_with_kind(self.model, "joint", joint) for joint in joints)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each degree of freedom: "m" or "rad"."""
        kinds = self.model.jnt_type[self.model.dof_jntid]
        firsts = self.model.jnt_dofadr[self.model.dof_jntid]
        slides = kinds == mujoco.mjtJoint.mjJNT_SLIDE
        free = kinds == mujoco.mjtJoint.mjJNT_FREE
        places = slides | (free & (np.arange(self.model.nv) - firsts < 3))
        return tuple("m" if place else "rad" for place in places.tolist())


def _set_fields(model: Any, fields: dict[str, Any]) -> None:
    """Copies numbers into fields of a compiled model."""
    for name, numbers in fields.items():
        getattr(model, name)[:] = numbers


def _touching(data: Any) -> tuple[Any, ...]:
    """Returns (kind, number, geoms) of each active limit and contact of the mjData, in a fixed
    order. A contact has the number -1, a limit has no geoms."""
    constraints = set[tuple[int, int, tuple[int, ...]]]()
    for kind, number in zip(data.efc_type.tolist(), data.efc_id.tolist(), strict=True):
        if kind >= FIRST_CONTACT:
            geoms = tuple(sorted(data.contact.geom[number].tolist()))
            constraints.add((kind, -1, geoms))
        elif kind >= FIRST_LIMIT:
            constraints.add((kind, number, ()))
    return tuple(sorted(constraints))


def touching_with_contacts(model: Any, data: Any, others: tuple[Any, ...]) -> tuple[Any, ...]:
    """Returns the constraints of `others` with the contacts of the mjData, which a port has filled,
    in place of their contacts."""
    constraints = {entry for entry in others if not entry[2]}
    cone = FIRST_CONTACT + 1 + int(model.opt.cone)
    for contact in data.contact:
        if contact.dist < contact.includemargin and contact.geom.min() >= 0:
            kind = cone if contact.dim > 1 else FIRST_CONTACT
            constraints.add((kind, -1, tuple(sorted(contact.geom.tolist()))))
    return tuple(sorted(constraints))
