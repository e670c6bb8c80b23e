"""pymunk as an engine: its methods and abilities. pymunk is imported when one of them is called."""

from __future__ import annotations

from plumbob.engines.abilities import SettingsToPaste
from plumbob.engines.adapters.pymunk.methods import METHODS
from plumbob.engines.method import Engine
from plumbob.models.scene import later

prepare = later(f"{__name__}.runs.prepared")
model_error = later(f"{__name__}.model_errors.model_error")
ENGINE = Engine(
    "pymunk",
    "pymunk",
    METHODS,
    prepare,
    model_error,
    abilities=(SettingsToPaste(later(f"{__name__}.settings_to_paste.settings")),),
)
