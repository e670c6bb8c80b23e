"""The audit of a user model: a certified reference of its continuous motion, and the errors of its
steps against the reference."""
