"""Which methods a system of a kind is for: those that say that they can do it, and no others."""

from plumbob.engines import registry
from plumbob.models.registry import built_in
from plumbob.models.scene import FREE_ROTATION, ON_PLANE, ON_SUPPORTS, ONE_SMOOTH, SMOOTH

OURS = [method for engine in registry.built_in().values() for method in engine.methods]


def test_each_system_of_ours_says_its_kind():
    kinds = {ONE_SMOOTH, SMOOTH, FREE_ROTATION, ON_SUPPORTS, ON_PLANE}
    assert {system.kind for system in built_in().values()} <= kinds
    assert all(s.kind == system.kind for system in built_in().values() for s in system.scenes)


def test_each_method_of_ours_says_what_it_is_for():
    assert not [m.name for m in OURS if not (m.kinds or any(p[0] != "!" for p in m.systems))]
