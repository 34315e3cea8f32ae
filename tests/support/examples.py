"""How hypothesis draws its examples."""

from hypothesis import settings

#: The same examples in each run, so that what fails on one machine fails on all.
reproducible = settings(derandomize=True, database=None)
