"""The engine reads a config, finds plugins, orders passes, runs them; it knows none by name."""
