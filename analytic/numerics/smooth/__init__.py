"""Smooth systems with any number of degrees of freedom: equations and a certified reference."""
