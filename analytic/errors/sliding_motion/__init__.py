"""Discretisation errors where friction switches inside a step: errors for one step size."""
