"""The arguments of the command line: every command with its options."""

from argparse import ArgumentParser
from typing import NoReturn

import zoh
from zoh.app.sweep_options import declare

BAD_INPUT = 2


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
    paper = commands.add_parser(
        "paper",
        help="the robot arm of the paper, every printed number beside the recomputed one",
        allow_abbrev=False,
    )
    paper.set_defaults(run="paper")
    design = commands.add_parser(
        "design", help="design, verify and compare the controllers of a file", allow_abbrev=False
    )
    design.set_defaults(run="design")
    check = commands.add_parser(
        "check",
        help="measure given controllers against requirements and claims",
        allow_abbrev=False,
    )
    check.set_defaults(run="check")
    explain = commands.add_parser(
        "explain",
        help="where each margin's degrees went, and what designing in s would have cost",
        allow_abbrev=False,
    )
    explain.set_defaults(run="explain")
    sweep = commands.add_parser(
        "sweep", help="a design over a grid or a random sample", allow_abbrev=False
    )
    sweep.set_defaults(run="sweep")
    export = commands.add_parser(
        "export", help="firmware that is the controller, bit for bit", allow_abbrev=False
    )
    export.set_defaults(run="export")
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
    for command in (paper, design, check, explain, sweep, export):
        command.add_argument("--json", action="store_true", help="print one JSON object")
    return whole
