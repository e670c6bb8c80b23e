"""A check that belongs to a finding."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Claim:
    """A check that a measured number supports the text of a finding. `text` states the failure, and
    is shown if `holds` is false."""

    text: str
    holds: bool
