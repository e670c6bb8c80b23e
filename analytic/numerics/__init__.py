"""Numerics that exact answers need: elliptic motion, rotors, collocation, 34 digits."""
