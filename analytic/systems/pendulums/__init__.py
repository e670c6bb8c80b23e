"""Exact motions of pendulums, undamped and driven, with their errors."""
