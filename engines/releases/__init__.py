"""Releases of an engine: each is installed alone, and measured in a process of its own."""
