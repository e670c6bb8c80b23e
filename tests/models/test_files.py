"""Every system's folder: what the adapter builds at the default parameters is the MJCF file, the
README states its numbers, and the picture is small."""

import re

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco import capsule, cone_pendulum, simple_pendulum
from plumbob.engines.adapters.mujoco.contacts import PROFILES
from plumbob.models.registry import case_of, scene, systems

# Softened further, because the armature of a compiled model needs it; and names and keys.
OTHERS = ("pair_solref", "pair_solimp", "key_", "name_", "names", "text")


@pytest.mark.parametrize(
    ("name", "whole", "relative", "absolute", "others"),
    [
        # inertia_x - M S^2 loses a digit that the file's formula keeps: a few 1e-15
        ("cone-pendulum", cone_pendulum.whole, 1e-14, 1e-18, ("_",)),
        ("simple-pendulum", simple_pendulum.whole, 1e-15, 0.0, ("_",)),
        ("capsule-line", capsule.whole, 1e-12, 1e-18, ("_", *OTHERS)),
    ],
)
def test_rebuilt_at_the_default_parameters_it_is_the_file(name, whole, relative, absolute, others):
    path = systems()[name].mjcf
    file = mujoco.MjModel.from_xml_path(str(path))
    rebuilt = whole(path, case_of(scene(name)).problem).compile()
    fields = {n: getattr(file, n) for n in dir(file) if not n.startswith(others)}
    arrays = {
        n: v for n, v in fields.items() if isinstance(v, np.ndarray) and v.dtype.kind in "fiub"
    }
    for field, values in arrays.items():
        found = getattr(rebuilt, field)
        np.testing.assert_allclose(found, values, relative, absolute, err_msg=field)
    assert sum(values.size > 0 for values in arrays.values()) > 50  # so that the loop is not empty
    np.testing.assert_array_equal(rebuilt.opt.gravity, file.opt.gravity)
    assert rebuilt.opt.disableflags == file.opt.disableflags or name == "simple-pendulum"


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


@pytest.mark.parametrize("folder", sorted({system.mjcf.parent for system in systems().values()}))
def test_the_picture_is_small(folder):
    (picture,) = folder.glob("*.png")
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size < 60_000
