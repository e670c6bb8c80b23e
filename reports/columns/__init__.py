"""Stored results as columns, for other programs, spreadsheets and papers."""
