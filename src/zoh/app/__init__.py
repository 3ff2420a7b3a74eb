"""The only room with files and arguments."""
