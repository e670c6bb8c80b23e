"""The free rigid body: its exact rotation, and what rounding and errors do to it."""
