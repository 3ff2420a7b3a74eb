"""Loops around plants of order 2 side by side, a lane a loop: each operation is done to all."""
