"""The proof: whether an .mbs is the same robot as a URDF, by a second route."""
