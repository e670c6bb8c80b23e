"""Numbers of findings that no measurement enters. They are computed when the package is tested, and
shipped as files; a study holds none of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plumbob.engines.study.codec import from_json

EXACT_NUMBERS = Path(__file__).parents[1] / "exact_numbers"  # folder of the files


@dataclass(frozen=True)
class ExactNumbers:
    """Numbers that follow from sources and exact motions alone, with the day and the versions of
    the packages with which they were computed."""

    date: str  # UTC, as 2026-01-31
    versions: Mapping[str, str]  # by package
    numbers: Mapping[str, Any]  # by their names in the template


def exact_numbers_file(template: str) -> Path:
    """Returns the path of the file with the exact numbers of a template; it need not exist."""
    return EXACT_NUMBERS / f"{template}.json"


def exact_numbers_of(template: str) -> ExactNumbers | None:
    """Returns the shipped numbers of a template; None if it has none."""
    file = exact_numbers_file(template)
    return from_json(file.read_text("utf-8"), ExactNumbers) if file.is_file() else None
