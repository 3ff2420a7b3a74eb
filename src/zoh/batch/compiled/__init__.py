"""The arithmetic of ``zoh.batch.arrays`` for one loop at a time, compiled by numba."""
