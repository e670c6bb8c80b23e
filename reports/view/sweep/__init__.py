"""Sweeps in words and pictures."""
