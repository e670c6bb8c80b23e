"""MuJoCo Warp as an engine: the MuJoCo adapter's models and users' model files, in single
precision, on the processor or the GPU that Warp chooses. Warp compiles kernels when they are first
called. A step is recorded as a graph, whose launch takes a hundredth of the time of calling the
step."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import Batches, RunsCopies, RunsFiles, SchemeOfCase
from plumbob.engines.adapters.ported import (
    EVERY,
    LOADED,
    SMOOTH,
    built,
    compiled,
    load_file,
    model_error,
    ported,
    scheme,
    started,
    timed,
    uncontrolled,
)
from plumbob.engines.adapters.stepping import stepped
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.engines.peer_model import RefusedFile
from plumbob.models.border import border
from plumbob.models.entry_points import captured
from plumbob.models.scene import Case

METHODS = (
    ported("mjwarp/default", "Euler", EVERY),
    ported("mjwarp/rk4", "RK4", SMOOTH),
)


def start_warp() -> None:
    """Loads Warp, and drops the lines that it prints about missing drivers and loaded kernels."""
    with captured():
        import warp

        warp.config.log_level = warp.LOG_ERROR
        warp.init()


class WarpPort:
    """A compiled model in MuJoCo Warp, in a number of `worlds`; raises RefusedFile."""

    def __init__(self, model: Any, worlds: int = 1) -> None:
        import mujoco

        start_warp()
        import mujoco_warp

        with border(RefusedFile):
            self.compiled, self.model = model, mujoco_warp.put_model(model)
            self.data = mujoco_warp.put_data(model, mujoco.MjData(model), nworld=worlds)

    def load(self, data: Any) -> None:
        """Copies the state, the controls and the applied forces of an mjData."""
        for name in LOADED:
            target = getattr(self.data, name)
            values = np.array(getattr(data, name), "f4")
            target.assign(np.broadcast_to(values, target.shape))

    def forward(self) -> None:
        """Computes all terms of the equations of motion."""
        import mujoco_warp

        mujoco_warp.forward(self.model, self.data)

    @cached_property
    def graph(self) -> Any:
        """The graph of one step."""
        import mujoco_warp
        import warp

        with warp.ScopedCapture() as capture:
            mujoco_warp.step(self.model, self.data)
        return capture.graph

    def steps(self, count: int) -> None:
        """Takes `count` steps."""
        import warp

        for _ in range(count):
            warp.capture_launch(self.graph)
        warp.synchronize()

    def step_under(self, controls: Array) -> None:
        """Takes a step under each of the controls, shape (steps, nu)."""
        import warp

        target = self.data.ctrl
        for control in controls.astype("f4"):
            target.assign(np.broadcast_to(control, target.shape))
            warp.capture_launch(self.graph)
        warp.synchronize()

    def state(self) -> tuple[Array, Array]:
        """The positions and velocities of the first world. They are copies: Warp's arrays on the
        processor are views."""
        return np.array(self.data.qpos.numpy()[0]), np.array(self.data.qvel.numpy()[0])

    def unload(self, data: Any) -> None:
        """Writes the state and all terms into an mjData."""
        import mujoco_warp

        mujoco_warp.get_data_into(data, self.compiled, self.data)


class WarpCopies:
    """A compiled model in MuJoCo Warp, stepped in batches; raises RefusedFile."""

    def __init__(self, model: Any, double: bool) -> None:
        """Warp computes in single precision: `double` is False."""
        self.compiled, self.port = model, WarpPort(model)
        self.sizes = model.nq, model.nq + model.nv

    def run(self, states: Array, warm_starts: Array, controls: Array) -> Array:
        """Returns the states of the copies, see `Copies.run`."""
        import warp

        batch = WarpPort(self.compiled, len(states))
        data = batch.data
        arrays = (data.qpos, data.qvel, data.act, data.qacc_warmstart)
        parts = [*np.split(states, self.sizes, axis=1), warm_starts]
        for array, part in zip(arrays, parts, strict=True):
            array.assign(part.astype("f4"))
        rows = [states]
        for held in np.moveaxis(controls, 1, 0):
            data.ctrl.assign(np.ascontiguousarray(held, "f4"))
            warp.capture_launch(batch.graph)
            warp.synchronize()
            rows.append(np.hstack([np.array(array.numpy(), float) for array in arrays[:3]]))
        return np.stack(rows, axis=1)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Compiles `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    translation, model = compiled(case, method, step)
    return stepped(
        case,
        step,
        lambda: built(started(WarpPort(model), translation, model), translation, step),
    )


def batch(
    case: Case, method: Method, step: float, worlds: int
) -> tuple[str, Callable[[int], float]]:
    """The device of a batch of `worlds` at the start of a case, and a function that takes a number
    of steps and returns the wall time [s]."""
    import warp

    translation, model = compiled(case, method, step)
    uncontrolled(translation)
    port = started(WarpPort(model, worlds), translation, model)
    return warp.get_device().name, partial(timed, port)


ENGINE = Engine(
    "mjwarp",
    "mujoco_warp",
    METHODS,
    prepare,
    model_error,
    optional=True,
    abilities=(
        SchemeOfCase(scheme),
        RunsFiles(partial(load_file, WarpPort), 2.0**-24),
        Batches(batch),
        RunsCopies(WarpCopies, (False,)),
    ),
)
