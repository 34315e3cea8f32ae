"""Run a project's own script without MBsysPy: ``python -m urdf2mbs_simulate workR/main.py``."""

import sys

from urdf2mbs_simulate.names import run_script

if len(sys.argv) < 2:
    sys.exit("usage: python -m urdf2mbs_simulate workR/main.py")
run_script(sys.argv[1])
