"""Matches two robots by the places, the masses and the order of their joints, without names."""
