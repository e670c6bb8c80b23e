"""MuJoCo Warp as an engine: the models of the MuJoCo adapter, and a user's model file, in single
precision, one world, on the processor or the GPU that Warp chooses. It compiles its kernels when
they are first called; a step is recorded as a graph, which takes a hundredth of calling it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import Batches, RunsFiles, SchemeOfCase
from plumbob.engines.adapters.ported import (
    EVERY,
    LOADED,
    PORTED,
    SMOOTH,
    built,
    compiled,
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
from plumbob.models.scene import Case, later

METHODS = (
    ported("mjwarp/default", "Euler", EVERY),
    ported("mjwarp/rk4", "RK4", SMOOTH),
)


def start_warp() -> None:
    """Load Warp without its lines: on a GPU's driver that is missing, on each kernel it loads."""
    with captured():
        import warp

        warp.config.log_level = warp.LOG_ERROR
        warp.init()


class WarpPort:
    """A compiled model in MuJoCo Warp, in as many `worlds`; raises RefusedFile."""

    def __init__(self, model: Any, worlds: int = 1) -> None:
        import mujoco

        start_warp()
        import mujoco_warp

        with border(RefusedFile):
            self.compiled, self.model = model, mujoco_warp.put_model(model)
            self.data = mujoco_warp.put_data(model, mujoco.MjData(model), nworld=worlds)

    def load(self, data: Any) -> None:
        """Take over the state, control and applied forces of an mjData."""
        for name in LOADED:
            held = getattr(self.data, name)
            held.assign(np.broadcast_to(np.array(getattr(data, name), "f4"), held.shape))

    def forward(self) -> None:
        """Work out all terms."""
        import mujoco_warp

        mujoco_warp.forward(self.model, self.data)

    @cached_property
    def _step(self) -> Any:
        import mujoco_warp
        import warp

        with warp.ScopedCapture() as capture:
            mujoco_warp.step(self.model, self.data)
        return capture.graph

    def steps(self, count: int) -> None:
        """Take steps."""
        import warp

        for _ in range(count):
            warp.capture_launch(self._step)
        warp.synchronize()

    def controlled(self, controls: Array) -> None:
        """Take a step under each of the controls, shape (steps, nu)."""
        import warp

        held = self.data.ctrl
        for control in controls.astype("f4"):
            held.assign(np.broadcast_to(control, held.shape))
            warp.capture_launch(self._step)
        warp.synchronize()

    def state(self) -> tuple[Array, Array]:
        """Positions and velocities of a world: copies, as Warp's arrays on the processor are
        views."""
        return np.array(self.data.qpos.numpy()[0]), np.array(self.data.qvel.numpy()[0])

    def unload(self, data: Any) -> None:
        """Fill in an mjData."""
        import mujoco_warp

        mujoco_warp.get_data_into(data, self.compiled, self.data)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Compile `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    translation, model = compiled(case, method, step)
    return stepped(
        case,
        step,
        lambda: built(started(WarpPort(model), translation, model), translation, step),
    )


def batch(
    case: Case, method: Method, step: float, worlds: int
) -> tuple[str, Callable[[int], float]]:
    """So many worlds from the start on."""
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
        RunsFiles(partial(later(PORTED), WarpPort), 2.0**-24),
        Batches(batch),
    ),
)
