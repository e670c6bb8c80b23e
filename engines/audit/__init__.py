"""How wrong a model of one's own is: a certified reference of its continuous motion, and its steps
held against that."""
