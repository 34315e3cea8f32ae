"""Meshes: read from the formats that URDFs use, written as the .wrl that Robotran shows."""
