"""What the code of a project should do: a file for each law, each by a second route.

What a law should give follows from the URDF and from the options of the passes.  The project's own
files are called at random states, and must give the same.
"""

from __future__ import annotations
