"""The driven rotor: an angle in a potential, damped and forced."""
