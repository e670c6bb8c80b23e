"""Shards of commands: the options that a shard refuses, and the line of a shard on the terminal."""

from __future__ import annotations

import argparse
import shlex

from plumbob.reports.commands.arguments import values
from plumbob.reports.view.tables import terminal_lines

# Options that `merge` has: a shard alone judges nothing and prints no results.
OPTIONS_OF_MERGE = ("within", "like", "json", "csv", "latex", "junitxml", "badge", "github")


def check_shard_options(chosen: argparse.Namespace) -> None:
    """Raises ParameterError if the user asks for a shard and for results of the whole."""
    if chosen.shard:
        given = [name for name in OPTIONS_OF_MERGE if hasattr(chosen, name)]
        values.refuse_options(chosen, given, "left out with --shard: see `plumbob merge`")


def whole_command(line: str) -> str:
    """Returns a command line without its option --shard."""
    words = shlex.split(line)
    for place, word in enumerate(words):
        # argparse takes any beginning of an option's name.
        if word.startswith("--sh"):
            del words[place : place + (1 if "=" in word else 2)]
            break
    return shlex.join(words)


def print_shard(chosen: argparse.Namespace, results: int, noun: str, missing: int = 0) -> None:
    """Prints the number of stored results of a shard, with a noun, and how shards are merged."""
    counts = {"results": results, "noun": noun, "missing": missing}
    lines = terminal_lines("shard", shard=chosen.shard, out=chosen.out, **counts)
    print(*lines, sep="\n")
