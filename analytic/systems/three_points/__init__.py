"""A rigid body on three Coulomb points: its motion from event to event, and a check of it."""
