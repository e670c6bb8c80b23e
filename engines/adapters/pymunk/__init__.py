"""pymunk as an engine: its methods, and the translation of a scene to a space."""

from __future__ import annotations

from plumbob.engines.abilities import SettingsToPaste
from plumbob.engines.adapters.pymunk.methods import METHODS
from plumbob.engines.method import Engine
from plumbob.engines.registry import model_error
from plumbob.models.scene import later

prepare = later(f"{__name__}.simulation.prepared")
ENGINE = Engine(
    "pymunk",
    "pymunk",
    METHODS,
    prepare,
    model_error,
    abilities=(SettingsToPaste(later(f"{__name__}.settings_to_paste.settings")),),
)
