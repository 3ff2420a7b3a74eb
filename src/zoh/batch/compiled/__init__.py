"""The arithmetic of ``zoh.batch.arrays`` for one loop, and for several side by side, compiled."""
