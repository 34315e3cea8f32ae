"""Files: how they are read safely, and which of them urdf2mbs has written."""
