"""Pages of the documentation say what the library does."""

import doctest
from pathlib import Path

import pytest

PAGES = [p for p in Path(__file__).parents[1].glob("docs/*.md") if ">>>" in p.read_text()]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_the_examples_of_a_page_run(page):
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    result = doctest.testfile(str(page), module_relative=False, optionflags=flags)
    assert result.attempted > 0
    assert result.failed == 0


def test_the_page_on_firmware_has_what_its_benchmark_prints():
    from benchmarks.firmware_numbers import lines

    page = (Path(__file__).parents[1] / "docs" / "firmware.md").read_text().splitlines()
    assert [line for line in lines() if line not in page] == []
