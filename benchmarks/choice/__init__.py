"""Is a chosen crossover ever beaten? A search of another kind, over the gains themselves."""
