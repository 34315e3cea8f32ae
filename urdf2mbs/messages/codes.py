"""What can happen anywhere."""

CODES = {"memory-full": "error: there is not enough memory"}
