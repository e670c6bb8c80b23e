"""Shows a model from its start and under its controls: in MuJoCo's viewer, or as pictures of the
offscreen renderer."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.adapters.mujoco.translation import with_visual_parts
from plumbob.engines.method import Method, Unsupported
from plumbob.models.border import border
from plumbob.models.scene import Case

# Name of the camera of every scene.xml, and the prefix that its elements get in a model
CAMERA, AROUND = "view", "around/"
# Distance by which the mass centre may move before the camera follows, as a fraction of the
# distance of the camera. Half the width of a picture is about 0.5.
FREE_PART = 0.2
CONTROLS_AHEAD = 1 << 16  # number of steps whose controls are computed at once


@dataclass(frozen=True)
class MujocoView:
    """A compiled model with its start, and the controls of each of its steps."""

    model: Any  # mjModel
    data: Any  # mjData at the start
    controls: Callable[[Array], Array | None]
    """Numbers of steps, shape (n,) -> their controls, shape (n, nu); None if nothing changes."""

    @property
    def step(self) -> float:
        """The time step [s]."""
        return float(self.model.opt.timestep)

    def states(self, marks: Sequence[int]) -> Iterator[Any]:
        """Yields the mjData at each of `marks`, which are rising numbers of steps taken."""
        data = self.data
        steps_taken = 0
        with options.collected():
            for mark in marks:
                while steps_taken < mark:
                    end = min(mark, steps_taken + CONTROLS_AHEAD)
                    steps = np.arange(steps_taken, end, dtype=float)
                    self._take(self.controls(steps), len(steps))
                    steps_taken = end
                mujoco.mj_forward(self.model, data)
                yield data

    def _take(self, controls: Array | None, count: int) -> None:
        """Takes `count` steps under their controls."""
        if controls is None:
            mujoco.mj_step(self.model, self.data, count)
            return
        for control in controls:
            self.data.ctrl[:] = control
            mujoco.mj_step(self.model, self.data)

    def frames(self, marks: Sequence[int], width: int, height: int) -> Iterator[Array]:
        """Yields the picture at each of `marks`, which are rising numbers of steps taken; a picture
        has the shape (height, width, 3). Raises Unsupported, which says what is missing, if no
        offscreen renderer works."""
        self.model.vis.global_.offwidth = width
        self.model.vis.global_.offheight = height
        cameras = (self._camera(name) for name in (AROUND + CAMERA, CAMERA))
        camera = next((number for number in cameras if number >= 0), -1)
        follow = self._follower(camera)
        with mujoco.Renderer(self.model, height, width) as renderer:
            for data in self.states(marks):
                follow(data)
                renderer.update_scene(data, camera)
                yield renderer.render().copy()

    def _follower(self, camera: int) -> Callable[[Any], None]:
        """Returns a function that moves a camera after the mass centre of the model, once the mass
        centre has gone FREE_PART of its distance from the camera."""
        if camera < 0:
            return lambda data: None
        place = np.array(self.model.cam_pos[camera])
        start = np.array(self.data.subtree_com[0])
        free_distance = FREE_PART * float(np.linalg.norm(self.data.cam_xpos[camera] - start))

        def follow(data: Any) -> None:
            """Moves the camera to its place for the state of `data`."""
            shift = data.subtree_com[0] - start
            distance = float(np.linalg.norm(shift))
            followed = 1.0 - free_distance / max(distance, free_distance)
            self.model.cam_pos[camera] = place + shift * max(0.0, followed)
            mujoco.mj_camlight(self.model, data)

        return follow

    def _camera(self, name: str) -> int:
        """Returns the number of a camera; -1, MuJoCo's free camera, if there is none."""
        return int(mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_CAMERA, name))

    def show(self) -> None:
        """Opens MuJoCo's viewer, and returns when its window is closed. Raises Unsupported if there
        is no display."""
        with border(_no_viewer), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # glfw warns of what is said below
            import glfw
            import mujoco.viewer

            displayed = bool(glfw.init())
        if not displayed:
            raise Unsupported("there is no display for the viewer; --gif and --png need none")
        mujoco.set_mjcb_control(self._control)
        try:
            with border(_no_viewer):
                mujoco.viewer.launch(self.model, self.data)
        finally:
            mujoco.set_mjcb_control(None)

    def _control(self, model: Any, data: Any) -> None:
        """Sets the controls of the step that begins."""
        controls = self.controls(np.array([np.floor(data.time / self.step + 0.5)]))
        if controls is not None:
            data.ctrl[:] = controls[0]


def _no_viewer(why: str) -> Unsupported:
    """Returns the error for a viewer that does not open."""
    return Unsupported(f"MuJoCo's viewer does not open: {why}")


def view_of_scene(case: Case, method: Method, step: float) -> MujocoView:
    """Returns the model of a case with its visual parts, and with the floor, light and camera of
    its folder, as a method of MuJoCo's steps it at `step` [s]. Raises Unsupported and
    ParameterError."""
    translation = compiled(case, method, step).translation
    spec = with_visual_parts(translation, case)
    options.apply(spec, method.settings, step)
    model = _with_surroundings(spec, case.system.mjcf)
    translation.tune(model)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = translation.qpos, translation.qvel
    mujoco.mj_forward(model, data)
    return MujocoView(model, data, lambda steps: translation.held_controls(steps, step))


def _with_surroundings(spec: mujoco.MjSpec, mjcf: Path) -> Any:
    """Returns the compiled model of `spec` with the floor, lights and camera that the file
    scene.xml beside `mjcf` puts around that model."""
    scene = mjcf.with_name("scene.xml")
    if not scene.is_file():
        return options.compiled(spec)
    without_model = {mjcf.name: b"<mujoco><statistic/></mujoco>"}
    around = mujoco.MjSpec.from_string(scene.read_text("utf-8"), include=without_model)
    headlight = around.visual.headlight
    for name in ("ambient", "diffuse", "specular"):
        setattr(spec.visual.headlight, name, getattr(headlight, name))
    for geom in around.geoms:
        geom.contype = geom.conaffinity = 0
    spec.attach(around, prefix=AROUND, frame=spec.worldbody.add_frame())
    return options.compiled(spec)
