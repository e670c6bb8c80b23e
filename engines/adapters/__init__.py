"""Adapters: scenes translated into each engine's terms."""
