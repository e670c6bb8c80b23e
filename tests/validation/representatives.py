"""What stands for the rest in the short suite of tests. Of pairs of scenes and methods two fifths:
every scene is among them, and of each system every method and every declared expectation. Of tests
that take seconds as many cases as their mark keeps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterable, Iterator, Sequence

import pytest

from plumbob.engines.method import Method
from plumbob.models.scene import Scene
from plumbob.reports.judge.expectations import expected

EVERY = 4
Pair = tuple[Scene, Method]


def representatives(chosen: Sequence[Pair]) -> list[Pair]:
    """Of the methods of a scene every fourth, beginning one further with each scene, so that every
    method meets scenes of each of its systems; and what is missing of `mechanisms`, once each."""
    places = dict.fromkeys(scene.name for scene, _ in chosen)
    begins = {name: -place for place, name in enumerate(places)}
    taken: dict[tuple[str, str], Pair] = {}
    met = Counter[str]()
    for scene, method in chosen:
        if (begins[scene.name] + met[scene.name]) % EVERY == 0:
            taken[scene.name, method.name] = (scene, method)
        met[scene.name] += 1
    seen = {one for pair in taken.values() for one in mechanisms(*pair)}
    for pair in chosen:
        if not seen.issuperset(mechanisms(*pair)):
            seen.update(mechanisms(*pair))
            taken[pair[0].name, pair[1].name] = pair
    return [pair for pair in chosen if (pair[0].name, pair[1].name) in taken]


def mechanisms(scene: Scene, method: Method) -> Iterator[Hashable]:
    """What a pair has in common with others: the scene; the system, with a method and with an
    expectation."""
    wanted = expected(scene.name, method.name)
    yield scene.name
    yield scene.system, method.name
    yield scene.system, wanted.verdict, wanted.other, wanted.reason


def left_out(items: Iterable[pytest.Item]) -> list[pytest.Item]:
    """Of the tests marked `long` those that the whole suite alone runs: all cases of each but the
    first `keep` that its mark names."""
    met, left = Counter[str](), list[pytest.Item]()
    for item in items:
        if (mark := item.get_closest_marker("long")) is None:
            continue
        name = item.nodeid.partition("[")[0]
        met[name] += 1
        if met[name] > mark.kwargs.get("keep", 0):
            left.append(item)
    return left
