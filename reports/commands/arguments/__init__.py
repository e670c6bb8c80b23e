"""Readers of the arguments of commands, and the console."""
