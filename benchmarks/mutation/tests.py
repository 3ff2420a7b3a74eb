"""The tests, collected once; a mutant runs in a forked copy of the process that holds them.

The code of the mutated function takes the place of the original's in the copy, so neither
imports nor collection are paid again: a mutant costs what its tests cost until one fails. Only
where a constant of a module changes, all modules are imported again. The parent never runs a
test, so that nothing remembers a result of the unchanged code.
"""

import ast
import importlib
import os
import pickle
import resource
import signal
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType, FunctionType, ModuleType

import coverage
import pytest
from benchmarks.mutation.mutants import Mutant

KILLED, SURVIVED, TIMEOUT, BROKEN = 1, 0, 124, 125
OPTIONS = ["-o", "addopts=--doctest-modules", "-p", "no:cacheprovider", "-p", "no:terminal"]
_MEMORY = 4 << 30  # bytes; a mutant may ask for any number of digits


@dataclass(kw_only=True)
class Recorded:
    """What one run of the unchanged code says of every test: s, and who runs which line."""

    seconds: dict[str, float] = field(default_factory=dict)
    lines: dict[tuple[str, int], set[str]] = field(default_factory=dict)
    failed: list[str] = field(default_factory=list)

    def of(self, mutant: Mutant) -> list[str]:
        """Return the tests that run the mutant's statement, the fastest first."""
        file = str(mutant.file.resolve())
        found = set().union(*(self.lines.get((file, line), ()) for line in mutant.lines))
        if not mutant.owner:  # run at import, seen by all who run anything there
            found = set().union(*(names for (f, _), names in self.lines.items() if f == file))
        found.discard("")
        return sorted(found, key=self.seconds.__getitem__)


class Tests:
    """Tests of pytest, collected in this process."""

    def __init__(self, paths: Iterable[str]) -> None:
        self._items: dict[str, pytest.Item] = {}
        self._failed = False
        self._serve: Callable[[], None] = lambda: None
        self._paths = list(paths)

    def serve(self, serve: Callable[[], None]) -> int:
        """Collect, then call ``serve`` inside pytest's session instead of running the tests."""
        self._serve = serve
        return int(pytest.main([*OPTIONS, *self._paths], plugins=[self]))

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        self._items = {item.nodeid: item for item in session.items}
        self._serve()
        return True

    def record(self, files: Iterable[Path]) -> Recorded:
        """Run every test once in a copy of this process, and say what it ran."""
        reader, writer = os.pipe()
        if not (child := os.fork()):
            os.close(reader)
            with os.fdopen(writer, "wb") as out:
                pickle.dump(self._recorded([str(f.resolve()) for f in files]), out)
            os._exit(0)
        os.close(writer)
        with os.fdopen(reader, "rb") as back:
            result = pickle.load(back)
        os.waitpid(child, 0)
        return result

    def _recorded(self, files: list[str]) -> Recorded:
        recorded = Recorded()
        seen = coverage.Coverage(data_file=None, include=files, messages=False)
        seen.start()
        for name in self._items:
            seen.switch_context(name)
            start = time.process_time()
            if self._fails(name):
                recorded.failed.append(name)
            recorded.seconds[name] = time.process_time() - start
        seen.stop()
        data = seen.get_data()
        for file in data.measured_files():
            for line, names in data.contexts_by_lineno(file).items():
                recorded.lines[file, line] = set(names)
        return recorded

    def _fails(self, name: str) -> bool:
        """Run one test, as its marks say, and return whether it or its fixtures failed."""
        self._failed, item = False, self._items[name]
        item.ihook.pytest_runtest_protocol(item=item, nextitem=None)
        return self._failed

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._failed |= report.failed

    def verdict(self, mutant: Mutant, names: list[str], seconds: float) -> tuple[int, str]:
        """Return how the mutant fares, and what killed it; ``seconds`` of the processor at most."""
        reader, writer = os.pipe()
        if not (child := os.fork()):
            code = BROKEN
            try:
                code = self._in_child(mutant, names, seconds, writer)
            finally:
                os._exit(code)
        os.close(writer)
        with os.fdopen(reader, "r") as back:
            killer = back.read()
        _, status = os.waitpid(child, 0)
        if os.WIFSIGNALED(status):
            return TIMEOUT, "time limit"
        if (code := os.WEXITSTATUS(status)) == BROKEN:
            raise RuntimeError(f"{mutant.name} could not be run")
        return code, killer

    def _in_child(self, mutant: Mutant, names: list[str], seconds: float, writer: int) -> int:
        signal.setitimer(signal.ITIMER_PROF, seconds)  # its signal ends the process
        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
        if not mutant.owner:
            import_again(mutant)
            # a file that is named itself is imported by pytest, out of reach of import_again
            named = [name for name in names if not name.startswith("src/")]
            return KILLED if pytest.main([*OPTIONS, "-x", *named]) else SURVIVED
        install(mutant)
        for name in names:
            if self._fails(name):
                os.write(writer, name.encode())
                return KILLED
        return SURVIVED


def install(mutant: Mutant) -> None:
    """Put the mutant's code in the place of the original's, in this process."""
    package = mutant.file.resolve().parts
    name = ".".join((*package[package.index("zoh") : -1], mutant.file.stem))
    module, path = importlib.import_module(name), mutant.owner.split(".")
    function = _function(module, mutant.owner)
    function.__code__ = _code(_compiled(mutant), path)
    _set_defaults(function, _definition(ast.parse(mutant.code), path).args, vars(module))


def _set_defaults(function: FunctionType, args: ast.arguments, names: dict) -> None:
    """Evaluate the defaults of the arguments anew: they are no part of a function's code."""

    def value(node: ast.expr) -> object:
        return eval(compile(ast.Expression(node), "<default>", "eval"), names)

    keywords = zip(args.kwonlyargs, args.kw_defaults, strict=True)
    function.__defaults__ = tuple(value(node) for node in args.defaults) or None
    function.__kwdefaults__ = {a.arg: value(node) for a, node in keywords if node is not None}


def _definition(tree: ast.AST, path: list[str]) -> ast.FunctionDef:
    for part in path:
        kinds = ast.FunctionDef | ast.ClassDef
        tree = next(n for n in tree.body if isinstance(n, kinds) and n.name == part)
    return tree


def _compiled(mutant: Mutant) -> CodeType:
    return compile(mutant.code, str(mutant.file), "exec", dont_inherit=True)


def import_again(mutant: Mutant) -> None:
    """Forget every module of this repository; the mutant is what will be imported next."""
    here, whole = str(Path.cwd()), SourceFileLoader.get_code
    for name, module in list(sys.modules.items()):
        if (getattr(module, "__file__", None) or "").startswith(here):
            del sys.modules[name]

    def get_code(self: SourceFileLoader, name: str) -> CodeType | None:
        changed = Path(self.path) == mutant.file.resolve()
        return _compiled(mutant) if changed else whole(self, name)

    SourceFileLoader.get_code = get_code


def _function(module: ModuleType, owner: str) -> FunctionType:
    holder: object = module
    *classes, last = owner.split(".")
    for part in classes:
        holder = getattr(holder, part)
    found = vars(holder)[last]
    return getattr(found, "__func__", found)


def _code(code: CodeType, path: list[str]) -> CodeType:
    for part in path:
        code = next(c for c in code.co_consts if isinstance(c, CodeType) and c.co_name == part)
    return code
