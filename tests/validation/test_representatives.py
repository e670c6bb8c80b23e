"""The short suite of tests leaves out what it says and no more, and everything is run elsewhere."""

import pytest

from plumbob.engines.registry import methods
from plumbob.engines.study.runner import pairs
from plumbob.models.registry import matching_scenes
from plumbob.tests.validation.representatives import mechanisms, representatives


@pytest.mark.long
def test_representatives_miss_no_mechanism():
    chosen = pairs(matching_scenes("*", "quick"), methods("*"))
    stand = representatives(chosen)
    assert {one for pair in chosen for one in mechanisms(*pair)} == {
        one for pair in stand for one in mechanisms(*pair)
    }
    # An engine that runs every system brings pairs that stand for themselves.
    assert len(stand) < 0.3 * len(chosen)
