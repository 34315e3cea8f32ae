"""URDF and xacro robots to Robotran ``.mbs`` multibody systems, provably the same robot."""
