"""The same examples on every machine and on every run; the command line, and a project file."""

import pytest
from hypothesis import HealthCheck, settings

from zoh.app.cli import main

settings.register_profile(
    "zoh", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("zoh")

GOOD = """\
[plant]
model = "2.3/(s^2 + 0.7809 s)"
[sensor]
gain = "12/180"
[sampling]
dt = 0.1
[[controller]]
name = "PI"
law = "pi"
wc = 0.8
pm_deg = 40
"""


@pytest.fixture
def good():
    return GOOD


@pytest.fixture
def zoh_main(capsys):
    """Return the command line as a function: arguments in, (code, stdout, stderr) out."""

    def command(*arguments):
        code = main([str(a) for a in arguments])
        out, err = capsys.readouterr()
        return code, out, err

    return command


@pytest.fixture
def run(tmp_path, zoh_main):
    """Return a function: the text of a file and more arguments in, (code, stdout, stderr) out."""

    def command(text, *more, verb="design"):
        file = tmp_path / "project.toml"
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return zoh_main(verb, file, *more)

    return command
