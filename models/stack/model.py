"""The relation of a stack of cubes to stack.xml."""

from __future__ import annotations

from typing import Any

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.stack import Stack
from plumbob.models.model_file import ModelFile


def fill(spec: Any, stack: Stack) -> None:
    """Writes the numbers of a stack into an MjSpec of stack.xml. The model gets as many cubes as
    the stack has, each on a slide along z."""
    half = stack.size / 2.0
    spec.option.gravity = [0.0, 0.0, -stack.gravity]
    slide, box = spec.joint("z_0").type, spec.geom("cube_0").type
    # Pairs are deleted before bodies: MuJoCo deletes the pairs of a body together with the body.
    for part in (*spec.keys, *spec.pairs, *spec.bodies[1:]):
        spec.delete(part)
    below = "ground"
    for number, mass in enumerate(stack.masses):
        name = f"cube_{number}"
        cube = spec.worldbody.add_body(name=name, pos=[0.0, 0.0, half * (2 * number + 1)])
        cube.add_joint(name=f"z_{number}", type=slide, axis=[0.0, 0.0, 1.0])
        cube.mass = mass
        cube.inertia = [mass * stack.size**2 / 6.0] * 3
        cube.explicitinertial = True
        cube.ipos = [0.0] * 3
        cube.iquat = [1.0, 0.0, 0.0, 0.0]
        cube.add_geom(name=name, type=box, size=[half] * 3)
        spec.add_pair(geomname1=below, geomname2=name, condim=1)
        below = name
    spec.add_key(name="start", qpos=[0.0] * stack.count)


def observe(stack: Stack, qpos: Array, qvel: Array) -> Signals:
    """Returns the rise of the top cube above the place where the file draws it."""
    return {"top": qpos[:, -1]}


MODEL = ModelFile(fill, observe)
