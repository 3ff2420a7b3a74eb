"""A crossover, a margin or a law that was left open, chosen: the fastest that meets everything."""
