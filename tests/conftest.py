"""The same examples on every machine and on every run; a project file and a way to run it."""

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
def run(tmp_path, capsys):
    """Return a function: the text of a file and more arguments in, (code, stdout, stderr) out."""

    def command(text, *more, verb="design"):
        file = tmp_path / "project.toml"
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        code = main([verb, str(file), *more])
        out, err = capsys.readouterr()
        return code, out, err

    return command
