"""The kit for plugin authors: a new pass, the schema of a config, the state after every pass."""
