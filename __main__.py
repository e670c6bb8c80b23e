"""`python -m plumbob`, and the command `plumbob`: an interrupt while it loads is one line, too."""

import sys

INTERRUPTED = 130


def main() -> int:
    """Run the command line; returns its exit code."""
    try:
        from plumbob.reports.cli import main as run

        return run()
    except KeyboardInterrupt:
        print("plumbob: interrupted", file=sys.stderr)
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
