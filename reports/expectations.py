"""What is known to go wrong, and why: strict, so that a limit that disappears is told."""

from __future__ import annotations

import fnmatch
from dataclasses import dataclass

from engines.method import Method
from models.scene import Scene
from reports.verdict import Judgement, Verdict


@dataclass(frozen=True)
class Expectation:
    """A verdict other than `pass` that scenes and methods of these patterns are to have."""

    scenes: str
    methods: str
    verdict: Verdict
    reason: str


EXPECTATIONS: tuple[Expectation, ...] = ()


def expected(scene: str, method: str) -> Expectation:
    """The first expectation that matches, or `pass`."""
    for entry in EXPECTATIONS:
        if fnmatch.fnmatchcase(scene, entry.scenes) and fnmatch.fnmatchcase(method, entry.methods):
            return entry
    return Expectation(scene, method, "pass", "")


def as_expected(scene: Scene, method: Method, found: Judgement) -> bool:
    """Whether a verdict is the expected one. What cannot be run breaks no promise; and a hard scene
    may be beyond every step of its ladder, which the page says, and which claims nothing."""
    if found.verdict in ("unsupported", "missing"):
        return True
    if found.verdict == "coarse" and scene.hard:
        return True
    return found.verdict == expected(scene.name, method.name).verdict
