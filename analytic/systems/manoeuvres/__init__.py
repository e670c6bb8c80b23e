"""The capsule's manoeuvres in closed form: line, turn, slow motion, holding and coasting."""
