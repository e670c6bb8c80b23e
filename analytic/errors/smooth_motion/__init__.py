"""Discretisation errors of smooth motions: power series in the step."""
