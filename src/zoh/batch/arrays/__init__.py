"""The whole verification of many loops at once, with NumPy alone: a loop a column."""
