"""Folders that several tests read."""

from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
ROOT = TESTS.parent
CONFIGS = ROOT / "configs"
#: Real robots and ``.mbs`` samples beside the checkout, which not everybody has.
SHARED = ROOT.parent / "shared"
