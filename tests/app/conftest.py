"""The command line with any arguments: (code, stdout, stderr)."""

import pytest

from zoh.app import cli


@pytest.fixture
def zoh_main(capsys):
    def command(*arguments):
        code = cli.main([str(a) for a in arguments])
        out, err = capsys.readouterr()
        return code, out, err

    return command
