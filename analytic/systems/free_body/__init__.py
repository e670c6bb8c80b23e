"""The free rigid body: its exact rotation, and the effects of rounding and errors on it."""
