"""An angle in a potential, damped and forced: its motion and the response of that to errors."""
