"""The proof: whether an .mbs is the same robot as a URDF, by a route of its own."""
