"""Verified loops as pictures."""
