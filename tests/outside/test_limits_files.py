"""A file of limits is read whole: an entry that is not known is refused, not passed over."""

from dataclasses import replace

import pytest

from plumbob.engines.added import wrong_limits
from plumbob.engines.registry import find_engine

LIMIT = """[[known_limits]]
scenes = ["capsule-hold/0.9"]
methods = ["ode/rk4"]
verdict = "off-prediction"
reason = "friction is regularised"
"""


@pytest.mark.parametrize(
    ("entry", "why"),
    [
        ("", ""),
        ('loosely_known = ["ode/rk4"]\n', ""),
        ("[sizes]\ntheta = 0.1\n", "unknown entries: sizes"),
        ("[[known_limit]]\nverdict = 3\n", "unknown entries: known_limit"),
    ],
)
def test_unknown_entries_are_refused(tmp_path, entry, why):
    """Sizes of errors stood in the same file before: if they were passed over, each limit would
    lose its size unsaid."""
    file = tmp_path / "tiny.toml"
    file.write_text(f"{LIMIT}{entry}" if entry.startswith("[") else f"{entry}{LIMIT}", "utf-8")
    said = wrong_limits(replace(find_engine("ode"), limits=file))
    assert said.endswith(why) if why else not said
