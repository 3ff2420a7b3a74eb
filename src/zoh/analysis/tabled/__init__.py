"""Measures of a loop that is known from a table: what it shows, and where it ends."""
