"""MuJoCo Warp as an engine: a user's model file in single precision, one world, on the processor or
the GPU that Warp chooses. It compiles its kernels when they are first called."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from plumbob.engines.abilities import RunsFiles, later
from plumbob.engines.adapters.stepping import no_error
from plumbob.engines.method import Engine, Method, Simulation, Unsupported
from plumbob.models.scene import Case

PORTED = "plumbob.engines.adapters.mujoco.terms.PortedModel"  # which imports MuJoCo
LOADED = ("qpos", "qvel", "act", "ctrl", "qfrc_applied", "qacc_warmstart")


class WarpPort:
    """A compiled model in MuJoCo Warp."""

    def __init__(self, model: Any) -> None:
        import mujoco
        import mujoco_warp
        import warp

        warp.config.quiet = True
        self.compiled, self.model = model, mujoco_warp.put_model(model)
        self.data = mujoco_warp.put_data(model, mujoco.MjData(model))

    def load(self, data: Any) -> None:
        """Take over the state, control and applied forces of an mjData."""
        for name in LOADED:
            getattr(self.data, name).assign(np.array(getattr(data, name), "f4")[None])

    def forward(self) -> None:
        """Work out all terms."""
        import mujoco_warp

        mujoco_warp.forward(self.model, self.data)

    def steps(self, count: int) -> None:
        """Take steps."""
        import mujoco_warp

        for _ in range(count):
            mujoco_warp.step(self.model, self.data)

    def unload(self, data: Any) -> None:
        """Fill in an mjData."""
        import mujoco_warp

        mujoco_warp.get_data_into(data, self.compiled, self.data)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Raises Unsupported: it has no method."""
    raise Unsupported("it runs models of your own in an audit, and no scenes")


ENGINE = Engine(
    "mjwarp",
    "mujoco_warp",
    (),
    prepare,
    no_error,
    optional=True,
    abilities=(RunsFiles(partial(later(PORTED), WarpPort), 2.0**-24, integrators=True),),
)
