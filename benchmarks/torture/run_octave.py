"""GNU Octave with its control package: ``margin``, ``isstable``, ``sensitivity``, in one process.

Only where ``octave-cli`` is installed. It is handed the z- or s-coefficients; a loop from
parameters is sampled by its own ``c2d``. ``margin`` gives one crossing of each kind, chosen by a
rule of its own, so any true one is right and missed ones are not asked of it. Where it found no
gain crossing it prints 180 deg at a frequency of NaN; that is taken as "none", which is right for a
loop that has none. Ms is asked of the loops it calls stable: of others it says infinity.
"""

import os
import shutil
import subprocess
import tempfile
from math import isnan
from pathlib import Path

from benchmarks.torture.loops import Spec
from benchmarks.torture.score import Answer

_PRELUDE = """pkg load control
warning('off', 'all');
function said(i, L)
  try
    [gm, pm, ~, w] = margin(L);
    if isnan(w)
      pm = Inf;
    end
    stable = isstable(feedback(L, 1));
    ms = NaN;
    if stable
      ms = sensitivity(L);
    end
    printf('%d %.17g %.17g %d %.17g\\n', i, gm, pm, stable, ms);
  catch e
    printf('%d error %s\\n', i, strrep(e.message, "\\n", ' '));
  end_try_catch
end
v = ver('control'); printf('version Octave %s, control %s\\n', OCTAVE_VERSION, v.Version);
"""


def installed() -> bool:
    return shutil.which("octave-cli") is not None


def answers(specs: list[Spec]) -> tuple[str, list[Answer]]:
    """Return (version, an answer for every loop)."""
    script = [_PRELUDE]
    found = {i: _cannot(spec) for i, spec in enumerate(specs)}
    script += [f"said({i}, {_loop(spec)});" for i, spec in enumerate(specs) if not found[i]]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "loops.m"
        path.write_text("\n".join(script))
        run = subprocess.run(
            ["octave-cli", "--quiet", "--no-history", str(path)],
            capture_output=True, text=True, check=False, env={**os.environ, "HOME": folder},
        )  # fmt: skip
    version, said = "Octave", dict.fromkeys(found, Answer(error="no answer"))
    said |= {i: Answer(cannot=reason) for i, reason in found.items() if reason}
    for line in run.stdout.splitlines():
        head, _, rest = line.partition(" ")
        if head == "version":
            version = rest
        elif head.isdigit():
            said[int(head)] = _read(rest)
    return version, [said[i] for i in range(len(specs))]


def _read(rest: str) -> Answer:
    if rest.startswith("error"):
        return Answer(error=rest)
    gm, pm, stable, ms = rest.split()
    return Answer(
        gm=float(gm), pm_deg=float(pm), stable=stable == "1", own_choice=True,
        ms=None if isnan(float(ms)) else float(ms),
    )  # fmt: skip


def _cannot(spec: Spec) -> str | None:
    if spec.get("dead_time"):
        return "dead time in a continuous loop"
    if spec["form"] == "params":
        samples = spec["plant"]["dead_time"] / spec["dt"]
        if abs(samples - round(samples)) > 1e-9:
            return "dead time of a fraction of a sample"
    return None


def _loop(spec: Spec) -> str:
    if spec["form"] == "z":
        return f"tf({_row(spec['num'])}, {_row(spec['den'])}, {spec['dt']!r})"
    if spec["form"] == "s":
        return f"tf({_row(spec['num'])}, {_row(spec['den'])})"
    plant, law, dt = spec["plant"], spec["controller"], spec["dt"]
    sampled = f"c2d(tf({_row(plant['num'])}, {_row(plant['den'])}), {dt!r}, 'zoh')"
    late = [1.0] + [0.0] * round(plant["dead_time"] / dt)
    parts = [sampled, f"tf(1, {_row(late)}, {dt!r})"]
    if "num" in law:
        return "*".join([*parts, f"tf({_row(law['num'])}, {_row(law['den'])}, {dt!r})"])
    terms = [f"tf({law['kp']!r}, 1, {dt!r})"]
    if law["ki"]:
        half = law["ki"] * dt / 2
        terms.append(f"tf({_row([half, half])}, [1 -1], {dt!r})")
    if law["kd"]:
        terms.append(f"tf({_row([law['kd'] / dt, -law['kd'] / dt])}, [1 0], {dt!r})")
    return "*".join([*parts, f"({'+'.join(terms)})"])


def _row(a: list[float]) -> str:
    return "[" + " ".join(repr(float(c)) for c in a) + "]"
