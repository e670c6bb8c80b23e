"""A user's body on its plane, under its own contact settings and under those of `plumbob
settings`."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count
from types import MappingProxyType
from typing import Any
from xml.sax.saxutils import quoteattr

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import Settings
from plumbob.engines.adapters.mujoco.contacts import DAMPING, REGULARISATION_RATIO, TOLERANCE
from plumbob.engines.adapters.mujoco.file_check import frequency_ratio
from plumbob.engines.adapters.mujoco.options import collected, integrator_number
from plumbob.engines.adapters.mujoco.own_model.model import (
    MujocoModel,
    own_model,
    start_data,
)
from plumbob.engines.adapters.mujoco.own_model.rigid_piece import (
    FLOOR,
    RigidPiece,
    rigid_piece,
)
from plumbob.engines.adapters.mujoco.own_model.user_stepper import diverged
from plumbob.engines.adapters.mujoco.settings_to_paste import (
    OWN_STIFFNESS,
    PAIRS,
    own_pair,
    settings,
)
from plumbob.engines.adapters.mujoco.terms import CompiledSteps
from plumbob.engines.adapters.mujoco.user_file import user_model
from plumbob.engines.method import time_step
from plumbob.engines.own_contacts import SlideToRest, Standing
from plumbob.engines.own_motion import NotCertifiable, Start
from plumbob.engines.peer_model import rotation
from plumbob.engines.registry import method as find_method
from plumbob.engines.trajectory import ByName

SETTLING, LONGEST = 0.5, 5.0  # [s] interval between checks for rest, and longest time to rest
FREE_SETTLING = 1.0  # [s] time in which the whole model settles with its joints free
# [m/s] largest speed of a body at rest, of any point at a radius of gyration from its centre of
# mass
AT_REST = 1e-4
FALLEN = math.radians(15.0)  # [rad] tilt while settling at which the body does not stand
# Speed, as a fraction of the speed at the start, and number of parts of a run after which a run
# ends
STILL, QUIET = 1e-5, 4
RESTS = 0.01  # largest speed of rest, as a fraction of the speed at the start
STABLE = 0.8  # fraction of the largest stiffness at which the body is stable
PARTS = 100  # number of parts of a run; in no part does the body turn by half a revolution
# {integrator: the method with settings for it}
METHODS = MappingProxyType(
    {
        "euler": "mujoco/euler+coulomb",
        "implicitfast": "mujoco/implicitfast+coulomb",
        "rk4": "mujoco/rk4+coulomb",
    }
)


class SettledFloor:
    """The body as a compiled piece that has settled on its plane, with contacts of some kind at
    some step."""

    def __init__(self, model: Any, piece: RigidPiece) -> None:
        self.model, self.names, self.data = model, piece.geoms, mujoco.MjData(model)
        # The radius of gyration [m] is about the vertical.
        self.gyration = math.sqrt(piece.inertia / float(model.body_mass[1]))
        with collected():
            self._settle()

    def _settle(self) -> None:
        """Lets the body come to rest, and reads its contacts there. Raises NotCertifiable if it
        diverges, falls over or does not come to rest."""
        model = self.model
        data = self.data
        count = max(1, round(SETTLING / model.opt.timestep))
        for _ in range(round(LONGEST / SETTLING)):
            mujoco.mj_step(model, data, count)
            upright = 1.0 - 2.0 * float(np.square(data.qpos[4:6]).sum())  # cosine of the tilt
            if not math.isfinite(upright) or data.warning.number.any():
                raise NotCertifiable(f"the body diverges at rest, at {model.opt.timestep:g} s")
            if upright < math.cos(FALLEN):
                raise NotCertifiable("the body falls over with its joints locked at the start")
            if self._speed() < AT_REST:
                break
        else:
            raise NotCertifiable(
                f"the body does not come to rest within {LONGEST:g} s, at {model.opt.timestep:g} s"
            )
        data.qpos[:2], data.qvel[:], data.time = 0.0, 0.0, 0.0
        mujoco.mj_forward(model, data)
        self.rest_qpos = np.array(data.qpos)
        contacts = data.contact
        # Contact points at rest relative to the centre of mass [m], shape (n, 3)
        self.points = contacts.pos.reshape(-1, 3) - data.qpos[:3]
        geoms = contacts.geom.reshape(-1, 2).max(axis=1)  # the plane is geom 0
        self.touching = [self.names[geom - 1] for geom in geoms]
        self.feet = tuple(dict.fromkeys(self.touching))
        self.frictions, self.dimensions = np.array(contacts.friction), np.array(contacts.dim)

    def _speed(self) -> float:
        """Returns the largest speed [m/s] of a point at a radius of gyration from the centre of
        mass."""
        velocity = self.data.qvel
        turning = self.gyration * np.linalg.norm(velocity[3:])
        return float(np.linalg.norm(velocity[:3]) + turning)

    def _begin(self) -> None:
        """Puts the body at rest where it has settled."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = self.rest_qpos

    def _run(self, duration: float, parts: int, still: float) -> tuple[Array, float]:
        """Returns the positions at the beginning and at the ends of `parts` of a `duration` [s],
        shape (n, 7), and the last speed [m/s]. The run ends early once the body has been slower
        than `still` [m/s] for QUIET parts."""
        count = math.ceil(duration / parts / self.model.opt.timestep)
        places = [np.array(self.data.qpos)]
        speeds = [math.inf] * QUIET
        with collected():
            while len(places) <= parts and max(speeds[-QUIET:]) >= still:
                mujoco.mj_step(self.model, self.data, count)
                places.append(np.array(self.data.qpos))
                speeds.append(self._speed())
        return np.array(places), speeds[-1]

    def slide(self, heading: float, speed: float, spin: float, duration: float) -> SlideToRest:
        """Returns the slide of the body that begins at `speed` [m/s] along `heading` [rad], turning
        at `spin` [rad/s], for `duration` [s]."""
        self._begin()
        direction = np.array([math.cos(heading), math.sin(heading)])
        self.data.qvel[:2] = speed * direction
        self.data.qvel[5] = spin
        first_speed = speed + self.gyration * abs(spin)
        places, last_speed = self._run(duration, PARTS, STILL * first_speed)
        axes = rotation(places[:, 3:])
        yaws = np.unwrap(np.arctan2(axes[:, 1, 0], axes[:, 0, 0]))
        return SlideToRest(
            float(places[-1, :2] @ direction),
            float(yaws[-1] - yaws[0]),
            last_speed < RESTS * first_speed,
        )

    def drift(self, heading: float, acceleration: float, duration: float) -> float:
        """Returns the speed [m/s] over the second half of `duration` [s] under a horizontal force
        through the centre of mass, of `acceleration` [m/s^2] times the mass."""
        self._begin()
        mass = float(self.model.body_mass[1])
        direction = np.array([math.cos(heading), math.sin(heading)])
        self.data.xfrc_applied[1, :2] = mass * acceleration * direction
        places, _ = self._run(duration, 2, 0.0)
        displacement = places[2, :2] - places[1, :2]
        return float(np.linalg.norm(displacement) / (self.data.time / 2.0))


def own_contacts(
    model: Any, start: Start, body: str | None, friction: float | None
) -> MujocoContacts:
    """Returns the free body `body`, or the heaviest, of a user's `model` on its plane, in the
    posture of its `start`, with sliding `friction` in place of its own. Raises ParameterError and
    NotCertifiable."""
    model, name, start = user_model(model, start)
    time_step("model", model.opt.timestep, name)
    with collected():
        data = start_data(model, start)
        piece = rigid_piece(model, data, body, friction)
        return MujocoContacts(
            **vars(piece), name=name, whole=model, start=start, friction=friction
        )


@dataclass(frozen=True)
class MujocoContacts(CompiledSteps, RigidPiece):
    """A user's body with its own contact settings, and with those of `plumbob settings`."""

    name: str
    whole: Any  # mjModel of the whole model
    start: Start
    # Sliding friction in place of the model's own; None: the model's own
    friction: float | None

    @property
    def method(self) -> str:
        """The method whose settings are pasted. An integrator without settings gets those of
        semi-implicit Euler."""
        return METHODS.get(self.integrator, METHODS["euler"])

    @cached_property
    def _settled(self) -> SettledFloor:
        """The body as it rests on its own contacts at its own step."""
        return self.own(self.step)

    @cached_property
    def standing(self) -> Standing:
        """The body as it rests on its own contacts. Raises NotCertifiable."""
        floor = self._settled
        friction = floor.frictions
        dimensions = floor.dimensions
        if (dimensions < 3).any():
            raise NotCertifiable("contacts with the plane have no friction (condim 1)")
        if (friction[:, 0] != friction[:, 1]).any():
            raise NotCertifiable("friction has two coefficients, one for each direction")
        moments = (dimensions > 3) & (friction[:, 2] > 0.0)
        return Standing(
            body=self.body,
            plane=self.plane,
            mass=float(self.model.body_mass[1]),
            inertia=self.inertia,
            gravity=-float(self.model.opt.gravity[2]),
            feet=floor.feet,
            points=floor.points[:, :2],
            height=-float(floor.points[:, 2].mean()),
            friction=tuple(friction[:, 0].tolist()),
            torsion=bool(moments.any()),
            locked=self.locked,
        )

    def let_go(self, speed: float) -> tuple[MujocoModel, int, Array]:
        """Returns the whole model at `speed` [m/s] along the plane's x axis, with its joints free,
        after it has settled under the controls of its start; the number of its body; and that axis,
        shape (3,). Raises NotCertifiable."""
        model = copy.copy(self.whole)
        if model.na:
            raise NotCertifiable("actuators have states of their own")
        if self.friction is not None:
            model.geom_friction[:, 0] = model.pair_friction[:, :2] = self.friction
        with collected():
            data = start_data(model, self.start)
            mujoco.mj_step(model, data, round(FREE_SETTLING / model.opt.timestep))
        if diverged(data):
            raise NotCertifiable(f"the whole model diverges within {FREE_SETTLING:g} s at rest")
        body = model.body(self.standing.body).id
        axis = data.geom_xmat[self.plane_number].reshape(3, 3)[:, 0].copy()
        data.qvel[:] = 0.0
        first = model.body_dofadr[body]
        data.qvel[first : first + 3] = speed * axis
        start = replace(self.start, qpos=data.qpos, qvel=data.qvel)
        return own_model(model, self.name, start), body, axis

    def frictions(self) -> ByName:
        """{foot: friction coefficient}."""
        return dict(zip(self._settled.touching, self.standing.friction, strict=True))

    def own(self, step: float) -> SettledFloor:
        """Returns the body on its own contacts at `step` [s]. Raises NotCertifiable if it does not
        settle."""
        model = copy.copy(self.model)
        model.opt.timestep = step
        return SettledFloor(model, self)

    def pasted(self, step: float) -> SettledFloor:
        """Returns the body on the pasted contacts, written for `step` [s]. Raises NotCertifiable if
        it does not settle."""
        return SettledFloor(self._pasted(step, self.stiffness), self)

    @cached_property
    def stiffness(self) -> float:
        """The natural frequency of one pasted contact times the step, chosen so that the body is
        stable."""
        ratio = frequency_ratio(self._pasted(self.step, OWN_STIFFNESS))
        largest = math.sqrt(4 * DAMPING**2 + 4.0 / ratio) - 2 * DAMPING
        stable = STABLE * largest
        digits = 10.0 ** (math.floor(math.log10(stable)) - 1)
        return min(OWN_STIFFNESS, math.floor(stable / digits) * digits)

    def _pasted(self, step: float, stiffness: float) -> Any:
        """Returns the compiled piece with the settings of the method, as they are pasted into MJCF
        alone."""
        spec = self.spec.copy()
        method = find_method(self.method)
        frictions = self.frictions()
        for pair in list(spec.pairs):
            spec.delete(pair)
        fields = own_pair(method, step, 1.0, stiffness)
        for number, name in enumerate(self.geoms):
            if name in frictions:
                added = spec.add_pair(geomname1=FLOOR, geomname2=f"geom_{number}", condim=3)
                added.friction[:2] = frictions[name]
                for field, values in fields.items():
                    getattr(added, field)[: len(values)] = values
        model = spec.compile()
        model.opt = self.model.opt
        model.opt.timestep = step
        model.opt.integrator = integrator_number(method.settings["integrator"])
        model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        model.opt.impratio, model.opt.tolerance = REGULARISATION_RATIO, TOLERANCE
        model.qpos0[:] = self._settled.rest_qpos
        return model

    @cached_property
    def _settings(self) -> Settings:
        """The settings of `plumbob settings` for the body."""
        friction = next(iter(self.frictions().values()))
        return settings(find_method(self.method), self.step, self.stiffness, friction)

    @property
    def first_order(self) -> float | None:
        """The predicted error of a stopping distance on the pasted contacts over the speed [s], at
        the model's own step, to first order in the step; None if there is no prediction."""
        return self._settings.stop_error_per_speed

    @property
    def overshoot(self) -> float:
        """The largest change of a load on the pasted contacts after a sudden force, over the change
        at which the load settles, for one contact. The modes of the body are damped more."""
        return 1.0 + math.exp(-math.pi * DAMPING / math.sqrt(1.0 - DAMPING**2))

    def snippet(self) -> str:
        """Returns contact settings to paste for the model's own step, the feet by their names. A
        pair needs names: a comment says which names the geoms without one have to get first."""
        frictions = self.frictions()
        new_names = self._new_names(frictions)
        plane = quoteattr(new_names.get(self.plane, self.plane))
        lines = ["<contact>"]
        if new_names:
            named = (f'name="{name}" for {geom}' for geom, name in new_names.items())
            text = ", ".join(named).replace("--", "- -")  # XML comments hold no "--"
            lines.insert(0, f"<!-- first name these geoms: {text} -->")
        for foot, mu in frictions.items():
            geom = quoteattr(new_names.get(foot, foot))
            lines.append(f'  <pair geom1={plane} geom2={geom} friction="{mu:g} {mu:g}"/>')
        lines.append("</contact>")
        return self._settings.snippets[0].mjcf.replace(PAIRS, "\n".join(lines))

    def _new_names(self, feet: Iterable[str]) -> dict[str, str]:
        """Returns {place of a geom without a name in the file: a name that it may get} for the
        plane and for the feet."""
        used_names = {self.whole.geom(number).name for number in range(self.whole.ngeom)}
        new_names: dict[str, str] = {}
        for place, stem in ((self.plane, "floor"), *((foot, "foot") for foot in feet)):
            if place not in used_names:
                numbered = (f"{stem}_{number}" for number in count(1))
                new_names[place] = next(name for name in numbered if name not in used_names)
                used_names.add(new_names[place])
        return new_names
