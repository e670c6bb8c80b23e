"""Pictures and words: tables, plots and the page."""
