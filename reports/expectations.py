"""What is known to go wrong, and why: strict, so that a limit that disappears is told."""

from __future__ import annotations

import fnmatch
from dataclasses import dataclass

from reports.verdict import Verdict


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
