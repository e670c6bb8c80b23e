"""Declares the arguments of a command from its TOML file in `reports/commands/options`."""

from __future__ import annotations

import argparse
import textwrap
import tomllib
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import USER_METHOD
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import systems
from plumbob.reports.commands.arguments import values

OPTIONS = Path(__file__).parents[1] / "options"
Reader = Callable[[Any], Any]  # from an argument's text to its value; raises ParameterError
NAMES = "names"  # placeholder of the text that lists the parameters of --set


def declare(
    parser: argparse.ArgumentParser, name: str, module: ModuleType, words: Sequence[str] = ()
) -> None:
    """Declares the arguments of the command `name` and those that its `module` adds. `words` are
    those of the command line, whose scene --help describes.

    The command's TOML file has a table for each argument, and `examples` of the command, which
    --help shows. The table's name is the argument's names, and its entries go to argparse as they
    are, except five. {NAME} in a text is the constant NAME of the module. `kind` is the function of
    `values` that reads the argument; `kinds` is the function that reads each part of a list.
    Exactly one of the arguments with `one_of` has to be given. `group` is the title under which
    --help lists the argument. An empty table stands for the table in `shared.toml`."""
    parser.set_defaults(readers={})
    file = OPTIONS / f"{name}.toml"
    if file.is_file():
        constants = vars(module) | {"USER_METHOD": USER_METHOD}
        shared = _read_toml(OPTIONS / "shared.toml", constants)
        alternatives: Any = None
        tables = _read_toml(file, constants)
        _show_examples(parser, tables.pop("examples"), words)
        groups: dict[str, Any] = {"": parser}
        for key, table in tables.items():
            if key == "parameters":
                parser.epilog = NAMES
                continue
            settings: dict[str, Any] = dict(table or shared[key])
            title = settings.pop("group", "")
            if settings.pop("one_of", False):
                if alternatives is None:
                    alternatives = parser.add_mutually_exclusive_group(required=True)
                _declare_argument(parser, alternatives, key, settings)
            else:
                if title not in groups:
                    groups[title] = parser.add_argument_group(title)
                _declare_argument(parser, groups[title], key, settings)
    if hasattr(module, "arguments"):
        module.arguments(parser)


def _show_examples(
    parser: argparse.ArgumentParser, examples: list[str], words: Sequence[str]
) -> None:
    """Adds examples of a command to its description in --help."""

    def formatter(prog: str) -> _Help:
        """Returns the formatter of the help of the program `prog`."""
        return _Help(words, prog=prog)

    # argparse calls what it takes for a class.
    parser.formatter_class = cast("type[_Help]", formatter)
    title = "example" if len(examples) == 1 else "examples"
    lines = [textwrap.fill(parser.description or "", 78), "", f"{title}:"]
    parser.description = "\n".join([*lines, *(f"  {example}" for example in examples)])


def _declare_argument(
    parser: argparse.ArgumentParser, group: Any, names: str, settings: dict[str, Any]
) -> None:
    """Adds an argument with these `names`, separated by spaces, to the parser or to one of its
    groups, and its reader to the parser's defaults. Errors name the argument by its last name."""
    for_argparse = {
        name: tuple(value) if name == "metavar" and isinstance(value, list) else value
        for name, value in settings.items()
        if name not in ("kind", "kinds")
    }
    argument = group.add_argument(*names.split(), **for_argparse)
    parameter = names.split()[-1].lstrip("-")
    readers: dict[str, Reader] = parser.get_default("readers")
    if "kind" in settings:
        readers[argument.dest] = partial(getattr(values, settings["kind"]), parameter)
    elif "kinds" in settings:
        read_part = partial(getattr(values, settings["kinds"]), parameter)
        readers[argument.dest] = partial(values.read_each, read_part)


def read_values(chosen: argparse.Namespace) -> None:
    """Replaces the texts of the arguments by their values. Raises ParameterError, also if the user
    asks for two forms of output."""
    forms = [name for name in ("json", "csv", "latex") if getattr(chosen, name, False)]
    if len(forms) > 1:
        raise ParameterError(forms[1], True, f"left out with --{forms[0]}")
    for name, reader in chosen.readers.items():
        text = getattr(chosen, name)
        if text is not None:
            setattr(chosen, name, reader(text))


def _read_toml(file: Path, constants: dict[str, Any]) -> dict[str, Any]:
    """Returns the tables of a TOML file, after each {NAME} is replaced by the constant NAME."""
    return tomllib.loads(file.read_text("utf-8").format_map(constants))


class _Help(argparse.RawDescriptionHelpFormatter):
    """Help text that looks up the parameters of the scene among the `words` of the command line
    only when it is printed, because loading the systems takes time."""

    def __init__(self, words: Sequence[str] = (), **settings: Any) -> None:
        super().__init__(**settings)
        self._words = words

    def add_text(self, text: str | None) -> None:
        super().add_text(_parameters_of_scene(self._words) if text == NAMES else text)


def _parameters_of_scene(words: Sequence[str]) -> str:
    """Returns a table of the parameters that --set takes for the first scene among the `words`:
    name, unit, default and meaning. Without a scene, says how to ask for it."""
    named = [word for word in words if word.partition("/")[0] in systems()]
    if not named:
        return "With a scene, --help also lists its parameters with units and defaults."
    from plumbob.reports.view.tables import terminal_lines
    from plumbob.reports.view.units import parameter_meanings, parameter_units

    scene = find_scene(named[0])
    return "\n".join(
        terminal_lines(
            "parameters",
            scene=scene,
            names=systems()[scene.system].parameters,
            units=parameter_units(),
            meanings=parameter_meanings(),
        )
    )
