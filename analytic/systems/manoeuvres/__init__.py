"""The manoeuvres of the capsule in closed form: line, turn, slow motion, holding, coasting."""
