"""Every system's folder: what the adapter builds at the default parameters is the MJCF file, the
README states its numbers, and the picture is small."""

import re

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.contacts import PROFILES
from plumbob.engines.adapters.mujoco.translation import filled
from plumbob.models.registry import built_in_systems, case_of, scene, systems

# Those of another system's file, with another joint, spring or slider, are left out.
SYSTEMS = [
    system
    for name, system in built_in_systems().items()
    if name == "capsule-line" or not name.startswith(("capsule-", "linear-"))
]
# Contacts are softened further, because the armature of a compiled model needs it; keys and looks.
OTHERS = ("_", "key_", "name", "geom_rgba", "pair_solref")


@pytest.mark.parametrize("system", SYSTEMS, ids=lambda system: system.name)
def test_rebuilt_at_the_default_parameters_it_is_the_file(system):
    file = mujoco.MjModel.from_xml_path(str(system.mjcf))
    case = case_of(scene(f"{system.name}/{system.default}"))
    rebuilt = filled(system.mjcf, system.model_file, case.problem).compile()
    fields = {n: getattr(file, n) for n in dir(file) if not n.startswith(OTHERS)}
    arrays = {
        n: v for n, v in fields.items() if isinstance(v, np.ndarray) and v.dtype.kind in "fiu"
    }
    for field, values in arrays.items():
        # inertia_x - M S^2 loses a digit that the cone's formula keeps: a few 1e-15
        np.testing.assert_allclose(getattr(rebuilt, field), values, 1e-12, 1e-18, err_msg=field)
    # so that the loop is not empty
    assert sum(values.size > 0 for values in arrays.values()) > 50
    np.testing.assert_array_equal(rebuilt.opt.gravity, file.opt.gravity)
    assert rebuilt.opt.disableflags == file.opt.disableflags


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        ("cone-pendulum", "mass|armature"),
        ("simple-pendulum", "mass|qpos|diaginertia"),
        ("capsule-line", "mass|armature"),
    ],
)
def test_the_readme_states_every_number_of_the_file(name, fields):
    file = systems()[name].mjcf
    text = (file.parent / "README.md").read_text("utf-8").replace("\u2212", "-")
    for number in re.findall(rf'(?:{fields})="([-\d.e]+)', file.read_text("utf-8")):
        assert number in text or float(number) == 1.0, number
    assert name != "capsule-line" or all(f"`{p}`" in text for p in PROFILES if p != "default")


@pytest.mark.parametrize(
    "folder", sorted({system.mjcf.parent for system in systems().values()})
)
def test_the_picture_is_small(folder):
    (picture,) = folder.glob("*.png")
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size < 60_000
