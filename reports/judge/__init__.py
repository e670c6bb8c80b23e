"""Is it within tolerance: tolerances, verdicts, expectations."""
