"""Verdicts on measured runs: tolerances, verdicts, and the verdicts that are expected."""
