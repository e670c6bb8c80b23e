"""The tests of the suite, a family a file."""
