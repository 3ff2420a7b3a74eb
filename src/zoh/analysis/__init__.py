"""Measures; knows nothing of design."""
