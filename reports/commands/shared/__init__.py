"""Code that several commands share: exact motions, model files, searches, rows of audits."""
