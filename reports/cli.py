"""The command `plumbob`: which words it takes, and what becomes of its errors."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from plumbob import __version__

USAGE = 2
COMMANDS = (
    "list", "validate", "report", "solve", "run", "recommend", "settings", "compare", "plan",
    "models", "cite",
)  # fmt: skip


class _Parser(argparse.ArgumentParser):
    """A parser whose complaint is one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(USAGE, f"{self.prog}: {message} (see `{self.prog} --help`)\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv`; returns 0 for all as expected, 1 for a verdict that is not, 2
    for wrong use or bad input, 3 for a missing engine or an incomplete study."""
    from plumbob.analytic.parameters import ParameterError

    try:
        words = list(sys.argv[1:] if argv is None else argv)
        first = [word for word in words[:1] if word in (*COMMANDS, "--version")]
        chosen = parser(first or COMMANDS).parse_args(words)
        return int(chosen.command(chosen))
    except ParameterError as error:
        print(f"plumbob: {error}", file=sys.stderr)
        return USAGE
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        if isinstance(error, BrokenPipeError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        print(f"plumbob: {where}{error.strerror or error}", file=sys.stderr)
        return USAGE
    except KeyboardInterrupt:
        print("plumbob: interrupted; nothing was written", file=sys.stderr)
        return 130


def parser(wanted: Sequence[str]) -> argparse.ArgumentParser:
    """The parser of the commands `wanted`, whose modules alone are loaded."""
    top = _Parser(prog="plumbob", description="Holds physics engines against exact answers.")
    top.add_argument("--version", action="version", version=f"plumbob {__version__}")
    commands = top.add_subparsers(metavar="COMMAND", required=True, parser_class=_Parser)
    for name in (name for name in wanted if name in COMMANDS):
        module = importlib.import_module(
            f"plumbob.reports.commands.{name}{'_' if name == 'list' else ''}"
        )
        described = (module.__doc__ or "").partition(": ")[2].strip().rstrip(".")
        command = commands.add_parser(name, help=described, description=f"{described}.")
        module.arguments(command)
        command.set_defaults(command=module.command)
    return top


if __name__ == "__main__":
    sys.exit(main())
