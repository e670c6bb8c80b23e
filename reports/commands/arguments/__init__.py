"""Code that several commands share: readers of their arguments, the console, runs and rows."""
