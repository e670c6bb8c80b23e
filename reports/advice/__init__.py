"""Which method and step: the cheapest that reach an error, found in stored runs or by searching."""
