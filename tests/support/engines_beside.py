"""A certified motion to hold engines against, and MuJoCo itself in the place of another."""

from functools import partial

import mujoco
import numpy as np

from plumbob.engines.abilities import ModelReader, RunsFiles
from plumbob.engines.adapters.mujoco.model_fields import fields_in
from plumbob.engines.adapters.mujoco.terms import PortedModel
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.engines import reference_motion
from plumbob.engines.audit.reference import certified
from plumbob.engines.method import Engine
from plumbob.engines.registry import find_engine
from plumbob.tests.audit.scenes_as_models import ready

EXACT = 2.0**-53
UNCHANGED = lambda model: None  # noqa: E731


def held(file, keyframe=None, control="rest", duration=0.2):
    """The certified motion of a file, all of it."""
    model = ready(str(file), keyframe)
    motion = script(model, control, duration)
    reference = certified(model, motion, Allowance(20.0))
    assert reference.until >= motion.duration * (1 - 1e-9)
    return reference_motion(file, model, motion, reference, len(motion.controls), 60.0)


class Changed:
    """MuJoCo as a port, with a change of the model, its state single after each step if
    asked."""

    def __init__(self, change, single, model):
        change(model)
        self.model, self.single, self.data = model, single, mujoco.MjData(model)

    def load(self, data):
        """The state, control and applied forces."""
        for name in ("qpos", "qvel", "act", "ctrl", "qfrc_applied", "qacc_warmstart", "time"):
            setattr(self.data, name, getattr(data, name))

    def forward(self):
        """All terms."""
        mujoco.mj_forward(self.model, self.data)

    def steps(self, count):
        """Steps, rounded if asked."""
        for _ in range(count):
            mujoco.mj_step(self.model, self.data)
            if self.single:
                for name in ("qpos", "qvel", "act"):
                    getattr(self.data, name)[:] = getattr(self.data, name).astype(np.float32)

    def unload(self, data):
        """All that it has."""
        mujoco.mj_copyData(data, self.model, self.data)


def changed(change=UNCHANGED, single=False, precision=EXACT):
    """MuJoCo in another engine's place, with a change of the compiled model."""
    load = partial(PortedModel, partial(Changed, change, single))
    genuine = find_engine("mujoco")

    def read(file):
        model = mujoco.MjModel.from_xml_path(str(file))
        change(model)
        return fields_in(model)

    runs = RunsFiles(load, precision)
    return Engine(
        "mujoco",
        "mujoco",
        (),
        genuine.prepare,
        genuine.model_error,
        abilities=(ModelReader(read), runs),
    )
