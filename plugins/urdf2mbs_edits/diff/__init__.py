"""The differences of two .mbs files: matched objects, and the changes of each."""
