"""Errors of fixed steps on the rotation of a free rigid body."""
