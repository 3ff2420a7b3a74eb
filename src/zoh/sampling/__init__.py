"""From s to z and w."""
