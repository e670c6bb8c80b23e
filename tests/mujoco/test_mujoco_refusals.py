"""What the MuJoCo adapter refuses, in one clear line, and which needless stages it leaves out."""

from dataclasses import replace

import mujoco
import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco import ENGINE, prepare
from plumbob.engines.method import Unsupported
from plumbob.tests.support.cone_scene import SYSTEM, scene

EULER = next(method for method in ENGINE.methods if method.name == "mujoco/euler")


@pytest.mark.parametrize("step", [0.0, -1e-4, float("nan"), float("inf"), 0.6, 1e-300])
def test_a_step_that_cannot_be_is_refused(step):
    with pytest.raises(ParameterError, match=r"^step = .*: must be [^\n]*$"):
        prepare(SYSTEM.case(scene()), EULER, step)


def test_a_model_without_memory_is_not_refused(monkeypatch):
    def compiled(spec):
        raise ValueError("Error: engine error: Could not allocate memory")

    monkeypatch.setattr(mujoco.MjSpec, "compile", compiled)
    with pytest.raises(MemoryError):
        prepare(SYSTEM.case(scene()), EULER, 1e-3)


@pytest.mark.parametrize(
    "text", [None, "", "no model", "<mujoco><worldbody></mujoco>", "<urdf/>"]
)
def test_a_file_that_is_no_model_is_refused(tmp_path, text):
    path = tmp_path / "wrong.xml"
    if text is not None:
        path.write_text(text, "utf-8")
    with pytest.raises(ParameterError, match=r"^mjcf = .*must be a MuJoCo model file [^\n]*$"):
        prepare(replace(SYSTEM, mjcf=path).case(scene()), EULER, 1e-3)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"integrator": "Verlet"}, "has no integrator 'Verlet'"),
        ({"viscousness": 1}, "has no option viscousness"),
    ],
)
def test_settings_that_mujoco_does_not_have_are_refused(settings, message):
    """Another release of MuJoCo may have them: the scene is unsupported, with that reason."""
    with pytest.raises(Unsupported, match=message):
        prepare(SYSTEM.case(scene()), replace(EULER, settings=settings), 1e-3)
