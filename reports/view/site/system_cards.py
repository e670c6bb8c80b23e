"""The cards of systems on the index: a thumbnail, the error of the default settings, and the
setting with the smallest error."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plumbob.reports.advice.recommend import DEFAULT_METHOD
from plumbob.reports.records.page_records import Replay
from plumbob.reports.view.method_results import TRUSTED_MEANINGS, MethodResult, ShownError

# largest ratio of the best setting's error to the default's that is worth a change
CLEARLY = 0.5


@dataclass(frozen=True)
class SystemCard:
    """The errors on the default scene of a system at the reference step. Errors of settings that
    are not trusted, or that are hardly smaller, are left out."""

    default: ShownError | None  # None if MuJoCo's default settings were not run
    best: ShownError | None  # the largest error at that step and at smaller steps
    method: str  # the method with that error
    thumbnail: str  # JSON for the page's script; empty if the scene has no drawing


def system_card(results: Sequence[MethodResult], replay: Replay | None) -> SystemCard:
    """Returns the card of a system, from the `results` of its default scene and its replay."""
    by_name = {result.name: result for result in results}
    default = by_name[DEFAULT_METHOD].at_reference if DEFAULT_METHOD in by_name else None
    engine = DEFAULT_METHOD.partition("/")[0]
    method, best = "", None
    smallest = CLEARLY * default.error if default else 0.0
    for result in results:
        trusted = result.meaning in TRUSTED_MEANINGS and not result.method.surrogate
        shown = result.largest_at_reference if trusted else None
        if result.method.engine == engine and shown and shown.error < smallest:
            method, best, smallest = result.name, shown, shown.error
    return SystemCard(default, best, method, replay.thumbnail if replay else "")


def thumbnails(cards: Mapping[str, SystemCard]) -> str:
    """Returns JSON with the thumbnails of the cards by the names of their systems; empty if no card
    has one."""
    drawn = [
        f"{json.dumps(name)}:{card.thumbnail}" for name, card in cards.items() if card.thumbnail
    ]
    return f"{{{','.join(drawn)}}}" if drawn else ""
