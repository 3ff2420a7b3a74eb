"""The hostile trials again under sanitisers: no overflow, no wild access, nothing undefined."""

import shutil
import subprocess

import numpy as np
import pytest
from designs import made

from zoh.firmware import harness
from zoh.firmware.c import emit
from zoh.firmware.model import Model
from zoh.firmware.trials import TYPES, differences, run, trials
from zoh.firmware.vectors import hostile
from zoh.firmware.words import result_type

SANITISED = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
# Reads a trial: how many samples, what is asked, what is given; writes every u, then the state.
MAIN = """\
#include <stdio.h>
#include <stdlib.h>
#include "ctl.h"
uint32_t zoh_size(void);
void zoh_run(ctl_state *s, const uint8_t *what, const %(kind)s *given, %(kind)s *out);
int main(void)
{
    uint32_t n;
    if (fread(&n, 4, 1, stdin) != 1) return 2;
    uint8_t *what = malloc(n + 1);
    %(kind)s *given = malloc(4 * n * sizeof *given), *out = malloc(n * sizeof *out);
    ctl_state *s = malloc(sizeof *s);
    if (fread(what, 1, n + 1, stdin) != n + 1) return 3;
    if (fread(given, sizeof *given, 4 * n, stdin) != 4 * n) return 4;
    zoh_run(s, what, given, out);
    fwrite(out, sizeof *out, n, stdout);
    fwrite(s, 1, zoh_size(), stdout);
    free(what), free(given), free(out), free(s);
    return ctl_selftest() == 0 ? 0 : 5;
}
"""


@pytest.fixture
def gcc():
    found = shutil.which("gcc")
    if found is None:
        pytest.skip("gcc, which has the sanitisers, is not here; CI has it")
    return found


def built(gcc, folder, plan, options):
    sources = {**emit(plan), "driver.c": harness.driver("ctl", plan.number)}
    sources["main.c"] = MAIN % {"kind": result_type(plan.number)}
    for name, text in sources.items():
        (folder / name).write_text(text)
    c = [name for name in sources if name.endswith(".c")]
    subprocess.run([gcc, "-std=c99", *options, *c, "-o", "made"], cwd=folder, check=True)
    return folder / "made"


def replayed(program, trial):
    n = trial.samples
    fed = np.uint32(n).tobytes() + trial.what.tobytes() + bytes([harness.END])
    return subprocess.run(
        [program], input=fed + trial.given.tobytes(), capture_output=True, check=False
    )


@pytest.mark.parametrize(
    ("law", "number"),
    [("pid", "q15"), ("notched", "q15"), ("lead", "q31"), ("leadlag", "q31"), ("pid", "f32")],
)
def test_no_sanitiser_speaks_and_every_bit_is_the_models(gcc, tmp_path, law, number):
    plan = made(law, number)
    program = built(gcc, tmp_path, plan, SANITISED)
    kind = np.dtype(TYPES[number])
    for trial in trials(number, hostile(plan, 4000)):
        done = replayed(program, trial)
        assert (done.returncode, done.stderr) == (0, b"")
        wanted = run(trial, lambda: Model(plan))
        end = trial.samples * kind.itemsize
        found = type(wanted)(
            outputs=np.frombuffer(done.stdout[:end], kind), state=done.stdout[end:]
        )
        assert list(differences(trial.title, wanted, found)) == []


def test_the_sanitisers_would_speak(gcc, tmp_path):
    # the same build of a controller whose gain is too large for its words
    plan = made("pid", "q15")
    built(gcc, tmp_path, plan, SANITISED)
    source = (tmp_path / "ctl.c").read_text()
    head, tail = source.split("ctl_kp = ", 1)
    (tmp_path / "ctl.c").write_text(f"{head}ctl_kp = 999999999;{tail[tail.index(';') + 1 :]}")
    c = ["ctl.c", "driver.c", "main.c"]
    subprocess.run([gcc, "-std=c99", *SANITISED, *c, "-o", "made"], cwd=tmp_path, check=True)
    done = replayed(tmp_path / "made", trials("q15", hostile(plan, 4000))[0])
    assert b"signed integer overflow" in done.stderr
