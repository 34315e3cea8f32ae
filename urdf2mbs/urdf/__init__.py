"""The language read: URDF, and xacro that expands to it."""
