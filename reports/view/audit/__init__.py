"""The answer of an audit as text, as a page and as JSON."""
