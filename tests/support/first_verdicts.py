"""The line that an audit prints on stderr before it has a reference."""

FIRST_VERDICT = "plumbob: first verdict: "


def without_first_verdict(said):
    """A text on stderr without that line."""
    lines = said.splitlines(keepends=True)
    return "".join(line for line in lines if not line.startswith(FIRST_VERDICT))
