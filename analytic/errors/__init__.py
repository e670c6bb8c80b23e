"""What schemes and contact models do to an exact motion (THEORY.md has the derivations)."""
