"""The public names are there, each loaded from where type checkers are told."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import zoh


def test_every_public_name_is_there():
    for name in zoh.__all__:
        assert getattr(zoh, name) is not None
    assert set(zoh.__all__) <= set(dir(zoh))


def test_type_checkers_are_told_the_same():
    tree = ast.parse(Path(zoh.__file__).read_text(encoding="utf-8"))
    told = {
        alias.name: node.module
        for branch in tree.body
        if isinstance(branch, ast.If)
        for node in branch.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    loaded = {name: home for home, names in zoh._HOMES.items() for name in names}
    assert told == loaded
    assert sorted(told) == sorted(zoh.__all__)


@pytest.mark.parametrize(
    "code",
    [
        "import zoh; assert callable(zoh.design)",
        "import zoh; zoh.pi; assert callable(zoh.design)",
        "from zoh.design import pid; import zoh; assert callable(zoh.design)",
        "from zoh import *; assert callable(design)",
        "import zoh; zoh.errors.ZohError; zoh.lti",
    ],
)
def test_the_design_function_is_never_hidden_by_the_package(code):
    subprocess.run([sys.executable, "-c", code], check=True)


def test_an_unknown_name_says_what_there_is():
    with pytest.raises(AttributeError, match=r"zoh has no 'margin'; it has .*margins"):
        _ = zoh.margin
