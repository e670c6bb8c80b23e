"""Mechanisms in pymunk's planar builder, for its tests."""

import mujoco
import numpy as np

from plumbob.engines.abilities import CompilesScenes
from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.adapters.pymunk.stepper import planar_stepper
from plumbob.engines.method import meant
from plumbob.engines.registry import find_engine, method, methods
from plumbob.engines.stepper import State
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene

TIGHT = method("pymunk/tight")


def scene_mechanism(name):
    """The mechanism of a scene, with its start and controls."""
    return find_engine("mujoco").ability(CompilesScenes).mechanism(case_of(find_scene(name)))


def method_for(name):
    """The last of pymunk's methods that is meant for a scene."""
    return [m for m in methods("pymunk") if meant(m, find_scene(name))][-1]


def stepper_of(name, step):
    """A scene's mechanism in pymunk at its start."""
    scene = scene_mechanism(name)
    stepper = planar_stepper(scene.mechanism, scene.start, method_for(name), step)
    stepper.put(scene.start)
    return stepper


def mechanism_of(mjcf):
    """The mechanism of a text of MJCF, MuJoCo's model of it, and the start in its first keyframe,
    or else at rest where it is drawn."""
    model = mujoco.MjModel.from_xml_string(mjcf)
    start = State(np.array(model.qpos0), np.zeros(model.nv))
    if model.nkey:
        start = State(np.array(model.key(0).qpos), np.array(model.key(0).qvel))
    return compiled_mechanism(model), model, start
