"""The largest step that holds: stability of steps, on linear systems and along a motion."""
