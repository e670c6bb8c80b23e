"""The check of a commit that changes words alone."""

import pytest

from plumbob.tests.contracts.same_code import code_of

TEXT = '''"""A file."""
LIMIT = 3  # [s] longest wait
"""A note under an attribute."""

def wait(seconds):
    """Wait."""
    return min(seconds, LIMIT)
'''


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"""A file."""', '"""Another sentence."""'),
        ("# [s] longest wait", "# [s] time that a worker waits at most"),
        ('"""A note under an attribute."""', ""),
        ('"""Wait."""', '"""Wait for so many seconds."""'),
    ],
)
def test_words_are_no_code(old, new):
    assert code_of(TEXT.replace(old, new)) == code_of(TEXT)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("LIMIT = 3", "LIMIT = 4"),
        ("min(seconds, LIMIT)", "min(LIMIT, seconds)"),
        ("    return min(seconds, LIMIT)", '    return "min"'),
    ],
)
def test_code_is(old, new):
    assert code_of(TEXT.replace(old, new)) != code_of(TEXT)
