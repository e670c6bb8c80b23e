"""An angle in a potential, damped and forced: its motion, and how that answers to errors."""
