"""The suite lives in benchmarks/torture, which is no installed package: it is found from here."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
