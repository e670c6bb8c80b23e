"""What fixed steps do to the rotation of a free rigid body."""
