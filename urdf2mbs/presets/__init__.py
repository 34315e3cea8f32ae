"""Pipelines under a name: each a config file of its own."""
