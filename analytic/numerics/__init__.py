"""Numerical methods of exact solutions: elliptic motion, rotors, collocation, 34 digits."""
