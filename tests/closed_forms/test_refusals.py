"""Impossible parameters of scenes are refused by name, in one line."""

import re
import tomllib
from pathlib import Path

import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.models.registry import scene
from plumbob.tests.support.extrapolation import tuples

ROWS = tomllib.loads(Path(__file__).with_name("refused.toml").read_text("utf-8"))["refused"]


@pytest.mark.parametrize(("name", "changes", "begins"), ROWS, ids=str)
def test_a_parameter_is_named(name, changes, begins):
    with pytest.raises(ParameterError, match=f"^{re.escape(begins)}[^\n]*$"):
        scene(name, tuples(changes))
