"""Robotran's .mbs: its model, reader and writer."""
