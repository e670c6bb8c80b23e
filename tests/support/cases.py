"""Cases for sensitivity tests: one scene is run and held against what is true of another."""

from __future__ import annotations

from dataclasses import replace

from plumbob.models.scene import Case


def held_against(case: Case, other: Case) -> Case:
    """The case with the exact motion of `other`, and with what is predicted of that."""
    return replace(case, reference=other.reference, errors=other.errors)
