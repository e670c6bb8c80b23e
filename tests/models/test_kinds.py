"""Which methods a system of a kind is for: those that say that they can do it, and no others."""

from dataclasses import replace

import pytest

from plumbob.engines import registry
from plumbob.engines.method import meant
from plumbob.models.registry import built_in_systems, scene
from plumbob.models.scene import (
    FREE_ROTATION,
    ON_PLANE,
    ON_SUPPORTS,
    ONE_SMOOTH,
    SMOOTH,
)

OURS = [method for engine in registry.built_in().values() for method in engine.methods]


def test_each_system_of_ours_says_its_kind():
    kinds = {ONE_SMOOTH, SMOOTH, FREE_ROTATION, ON_SUPPORTS, ON_PLANE}
    assert {system.kind for system in built_in_systems().values()} <= kinds
    assert all(
        s.kind == system.kind for system in built_in_systems().values() for s in system.scenes
    )


def test_each_method_of_ours_says_what_it_is_for():
    assert not [m.name for m in OURS if not (m.kinds or any(p[0] != "!" for p in m.systems))]


@pytest.mark.parametrize("name", ["double-pendulum", "capsule-flight", "new"])
def test_a_new_kind_is_nobodys(name):
    new = replace(scene("simple-pendulum/free-large"), name=f"{name}/free", kind="a new kind")
    assert not [m.name for m in OURS if meant(m, new)]


@pytest.mark.parametrize(
    ("systems", "chosen"),
    [
        (("simple-pendulum/free-*",), [True, False]),
        (("simple-pendulum", "!*/free-large"), [False, True]),
        ((), [True, True]),
    ],
)
def test_names_alone_choose_where_there_are_no_kinds(systems, chosen):
    one = replace(OURS[0], kinds=(), systems=systems)
    cases = ("free-large", "forced-small")
    assert [meant(one, scene(f"simple-pendulum/{case}")) for case in cases] == chosen
