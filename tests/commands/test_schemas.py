"""Schemas of what commands print with --json: complete, closed, and kept to.

Every other test that has a command print JSON holds it to the schema, too (tests/conftest.py)."""

import json
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from plumbob.reports.cli import main
from plumbob.reports.commands.list_ import SCHEMAS
from plumbob.tests.support.schemas import misses, validator

COMMANDS = [path.stem for path in sorted(SCHEMAS.iterdir())]
OPTIONS = Path(SCHEMAS).parents[1] / "commands" / "options"
RUN = ["run", "simple-pendulum/free-large", "mujoco/rk4", "--step", "0.01", "--json"]


def test_each_command_that_prints_json_has_a_schema():
    given = [path.stem for path in OPTIONS.iterdir() if '"--json"' in path.read_text("utf-8")]
    assert sorted({*given, "models"} - {"shared"}) == COMMANDS


@pytest.mark.parametrize("command", COMMANDS)
def test_a_schema_is_one_and_closed(command):
    """Every object of named properties says whether further ones are allowed; `solve` alone has
    what else is exact of a system beside them."""
    schema = validator(command).schema
    Draft202012Validator.check_schema(schema)

    def objects(part):
        parts = (
            part.values() if isinstance(part, dict) else part if isinstance(part, list) else ()
        )
        here = (
            [part]
            if isinstance(part, dict) and isinstance(part.get("properties"), dict)
            else []
        )
        return [*here, *(inner for p in parts for inner in objects(p))]

    open_ones = [o for o in objects(schema) if o.get("additionalProperties") is not False]
    assert len(open_ones) == (command == "solve")


def test_what_a_schema_does_not_allow_is_named(capsys):
    assert main(RUN) == 0
    answer = json.loads(capsys.readouterr().out)
    assert misses("run", answer) == ""
    for change in ({"errors": {"angle": "0.1"}}, {"step": None}, {"of_no_schema": 1}):
        assert misses("run", {**answer, **change}).startswith("run --json: $")
    del answer["verdict"]
    assert "verdict" in misses("run", answer)
