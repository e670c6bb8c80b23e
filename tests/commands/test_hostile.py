"""A few hostile inputs at random; `make test-long` has hundreds (hostile.py)."""

import pytest

from plumbob.tests.commands.hostile import MADE, searched

# None of these cases takes more than two seconds; the command line of seed 2 takes a minute.
SEEDS = range(3, 8)


@pytest.mark.long
@pytest.mark.parametrize("kind", MADE)
def test_hostile_input_is_no_defect(kind):
    _, wrong = searched(kind, SEEDS)
    assert wrong == []
