"""Errors that schemes and contact models make on an exact motion (derivations: THEORY.md)."""
