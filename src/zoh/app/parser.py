"""The arguments of the command line: every command with its options."""

from argparse import ArgumentParser
from typing import NoReturn

import zoh
from zoh.app.sweep_options import declare

BAD_INPUT = 2
_HELP = {
    "paper": "the robot arm of the paper, every printed number beside the recomputed one",
    "design": "design, verify and compare the controllers of a file",
    "check": "measure given controllers against requirements and claims",
    "explain": "where each margin's degrees went, and what designing in s would have cost",
    "sweep": "a design over a grid or a random sample",
    "export": "firmware that is the controller, bit for bit",
}


def one_line(text: str) -> str:
    """Return the text with its line ends as spaces.

    >>> one_line("a\\n b")
    'a b'
    """
    return " ".join(text.split())


class _Parser(ArgumentParser):
    """argparse, but an error is one line, as all of zoh's are."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong in one line and exit with 2."""
        self.exit(BAD_INPUT, f"zoh: error: {one_line(message)}: see {self.prog} --help\n")


def parser() -> ArgumentParser:
    """Return what reads the arguments; ``run`` is the name of the command."""
    whole = _Parser(
        prog="zoh",
        description="Digital controllers that provably meet their specification.",
        epilog="exit codes: 0 all met, 1 not met or impossible, 2 bad input",
        allow_abbrev=False,
    )
    whole.add_argument("--version", action="version", version=f"zoh {zoh.__version__}")
    commands = whole.add_subparsers(metavar="COMMAND", required=True)
    made = {}
    for name, does in _HELP.items():
        made[name] = commands.add_parser(name, help=does, allow_abbrev=False)
        made[name].set_defaults(run=name)
    paper, design, check, explain, sweep, export = made.values()
    export.add_argument("--target", choices=("c",), required=True, help="C99 that is C++17, too")
    export.add_argument("--controller", metavar="NAME", help="this one alone")
    export.add_argument("--number", choices=("f32", "f64", "q31", "q15", "auto"), default="f32")
    export.add_argument(
        "--prove", action="store_true", help="run it on seven emulated cores against the model"
    )
    for command in (design, check, explain, sweep, export):
        command.add_argument("file", metavar="FILE", help="a project file (TOML)")
    for command in (paper, design, explain):
        command.add_argument("--out", metavar="DIR", help="write a report with figures there")
    export.add_argument("--out", metavar="DIR", help="write the files there")
    for command in (paper, design, explain, export):
        command.add_argument("--force", action="store_true", help="let --out replace files")
    declare(sweep)
    for command in made.values():
        command.add_argument("--json", action="store_true", help="print one JSON object")
    return whole
