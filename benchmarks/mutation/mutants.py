"""Every mutant of a module that mutmut's operators make, each as the code of one function.

mutmut itself leaves out what stands outside functions and in decorated ones; constants at the
top of a module are mutated here all the same.
"""

import difflib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import libcst as cst
from libcst.metadata import MetadataWrapper, ParentNodeProvider, PositionProvider
from mutmut.mutation.file_mutation import MutationVisitor
from mutmut.mutation.mutators import mutation_operators
from mutmut.mutation.pragma_handling import get_ignored_lines


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mutant:
    """One change of one file.

    owner  the function or "Class.method" it is in, "" for the module itself
    lines  those of the statement changed: who runs one of them may see the change
    """

    file: Path
    number: int
    owner: str
    lines: range
    module: cst.Module
    before: cst.CSTNode
    after: cst.CSTNode

    @property
    def code(self) -> str:
        """The whole file, changed."""
        return self.module.deep_replace(self.before, self.after).code

    @property
    def place(self) -> str:
        """The file's name and the function's."""
        return f"{self.file.stem}.{self.owner or '<module>'}"

    @property
    def name(self) -> str:
        """The place, and which of the file's mutants it is."""
        return f"{self.place} #{self.number}"

    def diff(self) -> str:
        """Return the lines taken away and put in their place."""
        old, new = self.file.read_text().splitlines(), self.code.splitlines()
        changed = difflib.unified_diff(old, new, n=0, lineterm="")
        lines = (line for line in list(changed)[2:] if not line.startswith("@@"))
        return "\n".join(line.rstrip() for line in lines if len(line) > 1)


def mutants(file: Path) -> Iterator[Mutant]:
    """Yield every mutant of a file in the order of its lines."""
    source = file.read_text()
    wrapper = MetadataWrapper(cst.parse_module(source))
    visitor = MutationVisitor(mutation_operators, get_ignored_lines(str(file), source, wrapper))
    module = wrapper.visit(visitor)
    place, parent = wrapper.resolve(PositionProvider), wrapper.resolve(ParentNodeProvider)
    for number, mutation in enumerate(visitor.mutations):
        above = list(_up(mutation.original_node, parent))
        statement = next(n for n in above if isinstance(n, cst.BaseStatement | cst.Module))
        span = place[statement]
        yield Mutant(
            file=file,
            number=number,
            owner=_owner(above),
            lines=range(span.start.line, span.end.line + 1),
            module=module,
            before=mutation.original_node,
            after=mutation.mutated_node,
        )


def _up(node: cst.CSTNode, parent: dict) -> Iterator[cst.CSTNode]:
    while node is not None:
        yield node
        node = parent.get(node)


def _owner(above: list[cst.CSTNode]) -> str:
    """Return the outermost function, after its class if it has one."""
    named = [n for n in reversed(above) if isinstance(n, cst.FunctionDef | cst.ClassDef)]
    first = next((i for i, n in enumerate(named) if isinstance(n, cst.FunctionDef)), None)
    return "" if first is None else ".".join(n.name.value for n in named[: first + 1])
