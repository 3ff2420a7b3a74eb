"""One law per file: solve(plant, spec) -> law."""
