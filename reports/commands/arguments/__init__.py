"""Arguments that several commands take: values, and a model file of the user's own."""
