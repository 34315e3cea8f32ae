"""What is read from disk and written to it, and how safely."""
