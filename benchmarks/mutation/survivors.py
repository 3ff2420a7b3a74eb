"""Why mutants survive: ``survivors.txt`` gives a reason, then those that live for it.

A reason is a paragraph of lines that begin with "# "; each mutant after it is the place it is in
and the difference of lines it makes.
"""

from collections import Counter
from pathlib import Path

from benchmarks.mutation.mutants import Mutant

FILE = Path(__file__).with_name("survivors.txt")


def explained() -> dict[str, str]:
    """Return the reason for every survivor written down."""
    reasons, reason = {}, ""
    for paragraph in FILE.read_text().strip().split("\n\n"):
        if paragraph.startswith("# "):
            reason = " ".join(line.removeprefix("# ") for line in paragraph.splitlines())
        else:
            reasons[paragraph] = reason
    return reasons


def paragraph(mutant: Mutant) -> str:
    """Return a mutant as it is written down."""
    return f"{mutant.place}\n{mutant.diff()}"


def main() -> None:
    """Print how many live for which reason, as the table of docs/mutation.md."""
    for reason, count in Counter(explained().values()).most_common():
        print(f"| {count} | {reason} |")


if __name__ == "__main__":
    main()
