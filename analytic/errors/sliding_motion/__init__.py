"""Discretisation errors where friction switches inside a step: errors of a step as it is."""
