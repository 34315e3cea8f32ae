"""``python -m urdf2mbs`` is ``urdf2mbs``."""

import sys

from urdf2mbs.cli import main

if __name__ == "__main__":
    sys.exit(main())
