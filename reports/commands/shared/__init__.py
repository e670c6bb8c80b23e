"""What several commands do alike: exact motions, model files, searches, rows of audits."""
