"""JSON that commands print, held against their schemas."""

import json
import re
import sys
from functools import cache

from jsonschema import Draft202012Validator
from jsonschema.exceptions import best_match
from referencing import Registry, Resource

from plumbob.reports.commands.list_ import SCHEMAS
from plumbob.reports.records.plain_data import FOR_JSON, plain

COMMAND = re.compile(r"plumbob\.reports\.commands\.\w+")  # the module of a command


@cache
def validator(command):
    """Of what a command prints."""
    schemas = {file.name: json.loads(file.read_text("utf-8")) for file in SCHEMAS.iterdir()}
    names = [(name, Resource.from_contents(schema)) for name, schema in schemas.items()]
    registry = Registry().with_resources(names)
    return Draft202012Validator(schemas[f"{command}.json"], registry=registry)


def misses(command, value):
    """Where `value` departs most from the schema of `command`; nothing where it does not."""
    error = best_match(validator(command).iter_errors(plain(value, FOR_JSON)))
    return "" if error is None else f"{command} --json: {error.json_path}: {error.message}"


def held(print_json):
    """`print_json` that first holds what the command of the calling module prints to its schema."""

    def holding(value):
        frame = sys._getframe(1)
        # The functions of other folders print on behalf of a command.
        while not COMMAND.fullmatch(frame.f_globals["__name__"]):
            frame = frame.f_back
        name = frame.f_globals["__name__"].rpartition(".")[2].replace("_", "-")
        assert not misses(name, value), misses(name, value)[:500]
        print_json(value)

    return holding
