"""The command line: arguments in, tables or JSON out, an exit code that a script can trust.

0  everything asked for is met          2  bad input: one line that says what and how to mend it
1  a specification cannot be met, is not met, or a claim is wrong
"""

import json
import os
import sys
from argparse import Namespace
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any
from warnings import catch_warnings, simplefilter

import numpy as np

from zoh.app import files
from zoh.app.commands import Entry, check_all, design_all, hidden_instability, to_dict, warnings
from zoh.app.parser import BAD_INPUT, one_line, parser
from zoh.app.progress import shown_progress
from zoh.app.project import Project, read
from zoh.choice.map import Map
from zoh.errors import AccuracyWarning, Infeasible, NotMet, SpecError, ZohError

if TYPE_CHECKING:
    from zoh.app.sweep import Swept

MET, NOT_MET = 0, 1
DEFECT = 70  # EX_SOFTWARE: neither the input nor the specification is to blame
INTERRUPTED, PIPE_CLOSED = 130, 141  # 128 + SIGINT, 128 + SIGPIPE: what a shell expects


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; no traceback, whatever comes in."""
    arguments = parser().parse_args(argv)
    try:
        # an overflow that nobody foresaw is an error here, never a number
        if sys.stdout is None:
            return _fail(BAD_INPUT, "standard output must be open, got a closed one: redirect it")
        with np.errstate(over="raise", invalid="raise", divide="raise"), catch_warnings():
            simplefilter("ignore", AccuracyWarning)  # said with the design it is about
            code: int = _COMMANDS[arguments.run](arguments)
        sys.stdout.flush()  # a reader that left is noticed here, not at exit
    except BrokenPipeError:
        _abandon_stdout()
        return PIPE_CLOSED
    except KeyboardInterrupt:
        return INTERRUPTED
    except (Infeasible, NotMet) as e:
        return _fail(NOT_MET, str(e))
    except ZohError as e:
        return _fail(BAD_INPUT, str(e))
    except (FloatingPointError, np.linalg.LinAlgError) as e:
        way_out = "use units that bring its numbers nearer to 1"
        return _fail(BAD_INPUT, f"the file must stay within a float's range, {e}: {way_out}")
    except MemoryError:
        return _fail(BAD_INPUT, "this needs more memory than there is: ask for less at once")
    except OSError as e:
        return _fail(BAD_INPUT, f"{e.filename or 'output'}: {(e.strerror or str(e)).lower()}")
    except Exception as e:  # the last line of defence: a defect is not the user's bad input
        if os.environ.get("ZOH_DEBUG"):
            raise
        hint = "please report it; ZOH_DEBUG=1 shows where"
        return _fail(DEFECT, f"a defect of zoh, {type(e).__name__}: {e}: {hint}")
    return code


def _design(arguments: Namespace) -> int:
    project = read(files.read_text(arguments.file), files.beside(arguments.file))
    _refuse_early(arguments, "design.json")
    with shown_progress() as progress:
        entries = design_all(project, progress)
    result = to_dict(project, entries)
    if arguments.out is not None:
        report = _comparison(entries)
        _write(arguments, {"design.json": _json(result), **report})
    _show(arguments, project, entries, result)
    return _verdict(project, entries)


def _check(arguments: Namespace) -> int:
    project = read(files.read_text(arguments.file), files.beside(arguments.file))
    entries = check_all(project)
    _show(arguments, project, entries, to_dict(project, entries))
    return _verdict(project, entries)


def _explain(arguments: Namespace) -> int:
    from zoh.app import explain
    from zoh.app.explain_text import as_text

    project = read(files.read_text(arguments.file), files.beside(arguments.file))
    _refuse_early(arguments, "explain.json")
    with shown_progress() as progress:
        explained = explain.explain_all(project, progress)
    if arguments.out is not None:
        drawn = _with_matplotlib(lambda: _maps(explain.maps(project, explained)))
        _write(arguments, {"explain.json": _json(explain.to_dict(project, explained)), **drawn})
    if arguments.json:
        print(_json(explain.to_dict(project, explained)), end="")
    else:
        _console().out(as_text(project, explained))
    return _verdict(project, [e.entry for e in explained])


def _sweep(arguments: Namespace) -> int:
    from zoh.app.sweep import as_text, to_dict
    from zoh.app.sweep_command import swept

    if arguments.figures is not None:
        files.refuse_what_is_there(arguments.figures, ["sweep.json"], force=arguments.force)
    found = swept(arguments)
    if arguments.json:
        print(_json(to_dict(found)), end="")
    else:
        _console().out("\n".join(as_text(one) for one in found))
    if arguments.out is not None:
        print(f"zoh: wrote {arguments.out}", file=sys.stderr)
    if arguments.figures is not None:
        drawn = _with_matplotlib(lambda: _bands(found))
        contents = {"sweep.json": _json(to_dict(found)), **drawn}
        files.write_all(arguments.figures, contents, force=arguments.force)
        print(f"zoh: wrote {len(contents)} files to {arguments.figures}", file=sys.stderr)
    none = [one.name for one in found if one.summary.met == 0]
    if none:
        return _fail(NOT_MET, f"no loop is as asked and keeps every requirement: {', '.join(none)}")
    return MET


def _bands(found: "Sequence[Swept]") -> Mapping[str, str | bytes]:
    from zoh.app.sweep_figures import figures

    return figures((one.name, one.held) for one in found if one.held is not None)


def _export(arguments: Namespace) -> int:
    from zoh.app import export
    from zoh.app.proving import proving

    project = read(files.read_text(arguments.file), files.beside(arguments.file))
    _refuse_early(arguments, "README.md")
    with proving(arguments.prove) as prove:
        exported = export.export_all(
            project, number=arguments.number, only=arguments.controller, prove=prove
        )
    made = export.files(exported)
    if arguments.json:
        print(_json(export.to_dict(exported)), end="")
    else:
        _console().out(export.as_text(exported))
    if arguments.out is not None and made:
        _write(arguments, made)
    failing = [f"{e.entry.name}: {e.failure}" for e in exported if e.failure is not None]
    return _fail(NOT_MET, "; ".join(failing)) if failing else MET


def _maps(found: Iterable[tuple[Entry, Map]]) -> dict[str, str | bytes]:
    """Return each map as a figure and as data, the design marked on it."""
    from zoh.report.document import drawn
    from zoh.report.figures import render
    from zoh.report.map import law_figure
    from zoh.report.text import slug

    out: dict[str, str | bytes] = {}
    for entry, its_map in found:
        name = slug(f"map {entry.name}", [taken.rpartition(".")[0] for taken in out])
        margins = None if entry.measured is None else entry.measured.margins
        at = None
        if margins is not None and margins.crossover is not None:
            at = margins.crossover, margins.phase_margin_deg
        figure = law_figure(its_map, chosen=at, title=f"{entry.name}: what a {its_map.law} can do")
        out |= {**drawn(name, render(figure)), f"{name}.json": _json(its_map.to_dict())}
    return out


def _paper(arguments: Namespace) -> int:
    from zoh.app import paper

    _refuse_early(arguments, "paper.json")
    result = paper.run()
    if arguments.out is not None:
        report = _with_matplotlib(lambda: paper.report(result))
        _write(arguments, {"paper.json": _json(result), **report})
    if arguments.json:
        print(_json(result), end="")
    else:
        _console().print(paper.summary(result))
    return MET


_COMMANDS: Mapping[str, Callable[[Namespace], int]] = {
    "paper": _paper,
    "design": _design,
    "check": _check,
    "explain": _explain,
    "sweep": _sweep,
    "export": _export,
}


def _comparison(entries: Sequence[Entry]) -> Mapping[str, str | bytes]:
    def report() -> Mapping[str, str | bytes]:
        from zoh.report.document import comparison

        return comparison(
            [e.measured for e in entries if e.measured is not None],
            refused=[(e.name, e.refusal) for e in entries if e.refusal is not None],
        )

    return _with_matplotlib(report)


def _with_matplotlib(
    draw: Callable[[], Mapping[str, str | bytes]],
) -> Mapping[str, str | bytes]:
    try:
        return draw()
    except ModuleNotFoundError as e:
        if (e.name or "").split(".")[0] != "matplotlib":
            raise
        way_out = "pip install 'zoh[plot]' brings it"
        raise SpecError("--out", "must have matplotlib for its figures", "none", way_out) from None


def _refuse_early(arguments: Namespace, name: str) -> None:
    """Refuse a folder that is taken before the work, not after it."""
    if arguments.out is not None:
        files.refuse_what_is_there(arguments.out, [name], force=arguments.force)


def _write(arguments: Namespace, report: Mapping[str, str | bytes]) -> None:
    files.write_all(arguments.out, report, force=arguments.force)
    print(f"zoh: wrote {len(report)} files to {arguments.out}", file=sys.stderr)


def _show(
    arguments: Namespace, project: Project, entries: Sequence[Entry], result: Mapping[str, Any]
) -> None:
    if arguments.json:
        print(_json(result), end="")
        return
    from zoh.app.tables import show

    show(_console(), entries, warnings(project, entries))


def _verdict(project: Project, entries: Sequence[Entry]) -> int:
    """Return the exit code; what fails is named in one line, in full where it is one."""
    failing = [e for e in entries if e.failure is not None]
    if not failing:
        return MET
    named = [f"{e.name}: {e.failure}" if len(failing) == 1 else e.name for e in failing]
    hidden = hidden_instability(project)
    parts = [f"{len(failing)} of {len(entries)} controllers fail: {', '.join(named)}", hidden]
    return _fail(NOT_MET, "; ".join(part for part in parts if part))


def _console() -> Any:
    from rich.console import Console

    class Pipe(Console):
        """A console that leaves a closed pipe to ``main``; rich would exit with 1."""

        def on_broken_pipe(self) -> None:
            raise BrokenPipeError

    # a pipe has no width of its own, and a terminal that cannot show a sign gets a "?"
    if hasattr(sys.stdout, "reconfigure"):
        sys.stdout.reconfigure(errors="replace")
    return Pipe(file=sys.stdout, highlight=False, markup=False, emoji=False)


def _json(value: Mapping[str, Any]) -> str:
    return json.dumps(value, indent=2, allow_nan=False) + "\n"


def _fail(code: int, message: str) -> int:
    print(f"zoh: error: {one_line(message)}", file=sys.stderr)
    return code


def _abandon_stdout() -> None:
    """Let Python's last flush go nowhere: the reader has left (docs.python.org, SIGPIPE)."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError):  # a stdout without a file descriptor needs no care
        return


if __name__ == "__main__":
    sys.exit(main())
