"""What a system is."""
