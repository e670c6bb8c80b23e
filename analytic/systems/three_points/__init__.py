"""A rigid body on three Coulomb points, event after event, and an independent check of it."""
