"""Loops side by side, a lane a loop: the same is done to all, so that none waits for itself."""
