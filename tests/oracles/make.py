"""Write the 50-digit references beside this file: python tests/oracles/make.py [NAME ...].

Another road to the same numbers: mpmath, exact fractions, no line of zoh. The results are
committed, so the tests need no minutes and nobody can make them again by accident.
"""

import importlib
import json
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
NAMES = ("hold", "margins", "step", "delayed", "response")


def main(names):
    sys.path.insert(0, str(HERE))
    for name in names or NAMES:
        cases = importlib.import_module(f"truth_{name}").make()
        lines = ",\n".join(json.dumps(case) for case in cases)
        (HERE / f"{name}.json").write_text(f"[\n{lines}\n]\n")
        sys.stderr.write(f"{name}.json: {len(cases)} cases\n")


if __name__ == "__main__":
    main(sys.argv[1:])
