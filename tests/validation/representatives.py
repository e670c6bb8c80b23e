"""What stands for the rest in the short suite of tests. Of pairs of scenes and methods a quarter:
every scene is among them with an engine that is always there, of each family of systems every such
engine, of each kind of system every method, and of each system every declared expectation. Of tests
that take seconds as many cases as their mark keeps."""

from collections import Counter

import pytest

from plumbob.engines.registry import engine_of
from plumbob.engines.study.runner import predicted_work
from plumbob.models.registry import system_of
from plumbob.reports.judge.expectations import expected


def representatives(chosen):
    """All `mechanisms` of these pairs, each at least once, and where it takes the least work: about
    an evaluation of the motion for each order of a step."""
    of = {(scene.name, method.name): set(mechanisms(scene, method)) for scene, method in chosen}
    met = Counter(one for own in of.values() for one in own)
    most_first = sorted(chosen, key=lambda p: -predicted_work(*p, "quick") * (p[1].order or 1))
    for scene, method in most_first:
        own = of[scene.name, method.name]
        if all(met[one] > 1 for one in own):  # others stand for it
            met.subtract(own)
            del of[scene.name, method.name]
    return [pair for pair in chosen if (pair[0].name, pair[1].name) in of]


def mechanisms(scene, method):
    """What a pair has in common with others: the scene and the family of its system, where the
    engine is always there; the kind, which a method acts on; and the system with an expectation."""
    wanted = expected(scene.name, method.name)
    system = system_of(scene)
    engine = engine_of(method)
    if method.control == "step" and not engine.optional:
        yield scene.name
    if not engine.optional:  # the others build every system alike, from its mechanism
        yield system.family, engine.name
    yield system.kind, method.name
    yield scene.system, wanted.verdict, wanted.other, wanted.reason


def left_out(items, mark_name):
    """The cases of tests with this mark that a smaller suite leaves out: all cases of each test but
    the first `keep`, which its mark names."""
    met = Counter[str]()
    left = list[pytest.Item]()
    for item in items:
        if (mark := item.get_closest_marker(mark_name)) is None:
            continue
        name = item.nodeid.partition("[")[0]
        met[name] += 1
        if met[name] > mark.kwargs.get("keep", 0):
            left.append(item)
    return left
