"""The config: the YAML file that says what to convert and by which passes."""
