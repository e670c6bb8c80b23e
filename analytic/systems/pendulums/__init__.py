"""Exact motions of pendulums, undamped and driven, each with its errors."""
