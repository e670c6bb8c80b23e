"""What the sections on the capsule's systems share."""
