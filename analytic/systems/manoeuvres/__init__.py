"""The capsule's motions in closed form: line, turn, slow, held, coasting and repeated ones."""
