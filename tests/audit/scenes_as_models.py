"""Scenes of ours and small models as an audit gets them: compiled, without any exact answer."""

from dataclasses import dataclass, fields
from typing import Any

import mujoco
import numpy as np

from plumbob.engines.abilities import UserModels
from plumbob.engines.adapters.mujoco import ENGINE
from plumbob.engines.adapters.mujoco.own_model.model import MujocoModel, own_model
from plumbob.engines.adapters.mujoco.own_model.scene_model import scene_model
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.audit import audited
from plumbob.engines.audit.controls import script
from plumbob.engines.own_motion import Script, Start
from plumbob.engines.registry import method as find_method
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case

# A ball that bounces on a plane; 20 steps in a control period, and 5 periods of free fall.
BALL = """
<mujoco model="ball">
  <option timestep="0.001" integrator="{integrator}"><flag {flags}/></option>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 .1" solref="{solref}"/>
    <body name="ball" pos="0 0 {height}"><freejoint/>
      <geom size=".1" mass="1" solref="{solref}" friction="{friction}"/></body>
  </worldbody>
</mujoco>
"""
PENDULUM = """
<mujoco model="pendulum">
  <option timestep="0.01" integrator="{integrator}"/>
  <worldbody>
    <body name="rod"><joint name="hinge" axis="0 1 0"/>
      <geom type="capsule" size=".02" fromto="0 0 0 .5 0 0"/></body>
  </worldbody>
  <actuator><motor joint="hinge" ctrlrange="-1 1"/></actuator>
</mujoco>
"""


@dataclass(frozen=True)
class AuditedScene:
    """A scene of ours as a user's model, with what turns its states into observables."""

    case: Case
    model: MujocoModel
    observables: Any
    integrator: str  # of the method

    def script(self, duration, period):
        """Its start, uncontrolled for `duration` [s]."""
        return Script(
            self.model.state, period, np.tile(self.model.rest, (round(duration / period), 1))
        )

    def observed(self, states, name):
        """An observable of states, shape (n,)."""
        return np.asarray(self.observables(states)[name], dtype=float)


def scene_as_model(name, method, step, duration):
    """The model that the adapter compiles for a scene, method and step [s]."""
    case = case_of(find_scene(name)).lasting(duration)
    found = find_method(method)
    integrator = found.settings["integrator"].lower()
    return AuditedScene(case, *scene_model(case, found, step), integrator)


def ball(
    height=0.15, integrator="Euler", solref=".02 1", friction="1", flags='energy="disable"'
):
    """A compiled ball above a plane, its centre at `height` [m]; its radius is 0.1 m."""
    text = BALL.format(
        height=height, integrator=integrator, solref=solref, friction=friction, flags=flags
    )
    return compiled(text)


def pendulum(integrator="Euler"):
    """A compiled rod on a hinge, with a motor."""
    return compiled(PENDULUM.format(integrator=integrator))


def compiled(text):
    """A model of the text of its file."""
    return mujoco.MjModel.from_xml_string(text)


def audit_of(model, control="rest", keyframe=None, budget=60.0, **motion):
    """The audit of a model, compiled or ready, or of the text of its file; by default in far more
    processor time [s] than it takes."""
    if isinstance(model, str):
        model = compiled(model)
    own = (
        model if isinstance(model, MujocoModel) else own_model(model, "model", Start(keyframe))
    )
    return audited(own, script(own, control, **motion), control, Allowance(budget))


def recast(kind, model, **more):
    """A model as one of another class, with the fields that it has more."""
    return kind(**{f.name: getattr(model, f.name) for f in fields(MujocoModel)}, **more)


def ready(model, keyframe=None):
    """A model, or a file, as the engine gets it ready."""
    models = ENGINE.ability(UserModels)
    found = models.model(model, Start(keyframe))
    assert isinstance(found, MujocoModel)
    return found
