"""Runs over boxes of parameters: all points of a grid, and the worst point of a box."""
