"""Discretisation errors where nothing switches: power series in the step."""
