"""Which methods a system of a kind is for: those that say that they can do it, and no others."""

from dataclasses import replace

import pytest

from plumbob.engines import registry
from plumbob.engines.method import meant
from plumbob.models.registry import built_in, scene
from plumbob.models.scene import FREE_ROTATION, ON_PLANE, ON_SUPPORTS, ONE_SMOOTH, SMOOTH

OURS = [method for engine in registry.built_in().values() for method in engine.methods]


def for_kind(kind, name):
    """Names of the methods of plumbob's own that a new system of this kind and name is for."""
    new = replace(scene("simple-pendulum/free-large"), name=f"{name}/free", kind=kind)
    return {method.name for method in OURS if meant(method, new)}


@pytest.mark.parametrize("name", ["double-pendulum", "capsule-flight", "new"])
def test_a_new_kind_is_nobodys(name):
    assert not for_kind("a new kind", name)


def test_several_degrees_of_freedom_are_for_mujoco_and_solvers():
    found = {name for name in for_kind(SMOOTH, "double-pendulum") if not name.startswith("ode/")}
    assert found == {"mujoco/euler", "mujoco/rk4", "heyoka/taylor"}


@pytest.mark.parametrize("kind", [ONE_SMOOTH, FREE_ROTATION, ON_SUPPORTS, ON_PLANE])
def test_each_other_kind_is_for_the_closed_form_and_mujoco(kind):
    found = for_kind(kind, "new")
    assert {"exact/closed-form", "mujoco/euler", "mujoco/rk4"} < found


def test_each_system_of_ours_says_its_kind():
    kinds = {ONE_SMOOTH, SMOOTH, FREE_ROTATION, ON_SUPPORTS, ON_PLANE}
    assert {system.kind for system in built_in().values()} <= kinds
    assert all(s.kind == system.kind for system in built_in().values() for s in system.scenes)


def test_each_method_of_ours_says_what_it_is_for():
    assert not [m.name for m in OURS if not (m.kinds or any(p[0] != "!" for p in m.systems))]


def test_names_alone_choose_where_there_are_no_kinds():
    large, forced = (scene(f"simple-pendulum/{case}") for case in ("free-large", "forced-small"))
    one = replace(OURS[0], kinds=(), systems=("simple-pendulum/free-*",))
    assert meant(one, large)
    assert not meant(one, forced)
    assert not meant(replace(one, systems=("simple-pendulum", "!*/free-large")), large)
    everything = replace(one, systems=())
    assert meant(everything, large)
    assert meant(everything, scene("capsule-coast"))
