"""Cases for sensitivity tests: one scene is run and compared with the answer to another."""

from __future__ import annotations

from dataclasses import replace

from plumbob.models.scene import Case


def held_against(case: Case, other: Case) -> Case:
    """The case with the exact motion of `other` and its predictions."""
    return replace(case, reference=other.reference, errors=other.errors)
