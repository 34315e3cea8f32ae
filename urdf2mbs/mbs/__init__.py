"""The language written: Robotran's .mbs."""
