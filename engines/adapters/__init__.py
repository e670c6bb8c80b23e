"""Adapters: a module or a folder for each engine, which translates scenes into the engine's
terms."""
