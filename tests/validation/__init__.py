"""The registry as a test suite: every scene with every method."""
