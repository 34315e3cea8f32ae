"""The processes of a machine: work on all cores, and what ends them."""
