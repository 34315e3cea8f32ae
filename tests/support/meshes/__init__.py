"""Meshes of each format, and robots that show them."""
