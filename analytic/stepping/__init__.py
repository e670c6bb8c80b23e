"""What a fixed step makes of a motion: schemes, global errors, drifts, kinks."""
