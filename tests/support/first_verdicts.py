"""The lines that an audit prints on stderr before its result."""

import re

FIRST_VERDICT = "plumbob: first verdict: "
AUDITED = re.compile(r"plumbob: \d+ of \d+: .* audited$")


def without_first_verdict(said):
    """A text on stderr without the first verdict and without the lines of audited models."""
    lines = [
        line for line in said.splitlines(keepends=True) if not AUDITED.match(line.rstrip())
    ]
    return "".join(line for line in lines if not line.startswith(FIRST_VERDICT))
