"""Records that analyses compute and pages show, and the notation of numbers in texts."""
