"""Settings of methods that a reader may copy from the page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from plumbob.engines.abilities import Settings
from plumbob.reports.records.page_records import SHOWN_SETTINGS


@dataclass(frozen=True)
class TitledSettings:
    """The settings of one method with a title."""

    title: str
    settings: Settings


def shown_settings(settings: Mapping[str, Settings]) -> tuple[TitledSettings, ...]:
    """Returns the settings that a study's page shows; `settings` are all settings of the study, by
    method."""
    return tuple(
        TitledSettings(title, settings[name])
        for name, title in SHOWN_SETTINGS
        if name in settings
    )
