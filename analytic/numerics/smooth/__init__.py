"""Smooth systems of any number of degrees of freedom: equations, and a certified reference."""
