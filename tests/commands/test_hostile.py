"""A few hostile inputs at random; `make test-long` has hundreds (hostile.py)."""

import pytest

from plumbob.tests.commands.hostile import MADE, searched


@pytest.mark.long
@pytest.mark.parametrize("kind", MADE)
def test_hostile_input_is_no_defect(kind):
    _, wrong = searched(kind, range(5))
    assert wrong == []
