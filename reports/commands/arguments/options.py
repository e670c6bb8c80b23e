"""The arguments of a command, as its file in `reports/commands/options` has them."""

from __future__ import annotations

import argparse
import textwrap
import tomllib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from plumbob.engines.method import USER_METHOD
from plumbob.models.registry import systems
from plumbob.reports.commands.arguments import values

OPTIONS = Path(__file__).parents[1] / "options"
Reader = Callable[[Any], Any]  # of an argument's text; raises ParameterError
NAMES = "names"  # an epilog: what --set takes


def declare(parser: argparse.ArgumentParser, name: str, module: ModuleType) -> None:
    """Declare the arguments of a command, those that its module adds too. A table a argument: its
    names, and what argparse takes of it; {NAME} is the module's own, `one_of` an argument of which
    one has to be there, and `kind`, or `kinds` of a list, the function of `values` to read it."""
    readers: dict[str, Reader] = {}
    parser.set_defaults(readers=readers)
    if (file := OPTIONS / f"{name}.toml").is_file():
        names = vars(module) | {"USER_METHOD": USER_METHOD}
        shared = _read(OPTIONS / "shared.toml", names)
        one_of: Any = None
        for key, of in _read(file, names).items():
            if key == "parameters":
                parser.formatter_class, parser.epilog = _Help, NAMES
                continue
            settings: dict[str, Any] = of or shared[key]
            place: Any = parser
            if settings.pop("one_of", False):
                place = one_of = one_of or parser.add_mutually_exclusive_group(required=True)
            if isinstance(settings.get("metavar"), list):
                settings["metavar"] = tuple(settings["metavar"])
            kind = settings.pop("kind", "")
            kinds = settings.pop("kinds", "")
            dest = place.add_argument(*key.split(), **settings).dest
            if kind or kinds:
                reader: Reader = partial(getattr(values, kind or kinds), key.lstrip("-"))
                readers[dest] = partial(values.each, reader) if kinds else reader
    if hasattr(module, "arguments"):
        module.arguments(parser)


def read(chosen: argparse.Namespace) -> None:
    """Put values in the place of the texts that were chosen; raises ParameterError."""
    for name, reader in chosen.readers.items():
        if (text := getattr(chosen, name)) is not None:
            setattr(chosen, name, reader(text))


def _read(file: Path, names: dict[str, Any]) -> dict[str, Any]:
    return tomllib.loads(file.read_text("utf-8").format_map(names))


class _Help(argparse.RawDescriptionHelpFormatter):
    """Help that looks the names of parameters up when it is printed: systems take time to load."""

    def add_text(self, text: str | None) -> None:
        super().add_text(_names() if text == NAMES else text)


def _names() -> str:
    """Every system with its parameters, a paragraph each."""
    each = (
        textwrap.fill(
            ", ".join(system.parameters),
            78,
            initial_indent=f"  {name}: ",
            subsequent_indent="    ",
            break_on_hyphens=False,
        )
        for name, system in systems().items()
    )
    return "\n".join(("parameters that --set takes:", *each))
