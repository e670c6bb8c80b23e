"""Recommendations of a method and a step: the cheapest that reach an error, found in stored runs or
by a search."""
