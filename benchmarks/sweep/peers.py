"""Others at the sweep's job, each called once for all its loops; see ``benchmarks.sweep.speed``."""

import shutil
import subprocess
import tempfile
from contextlib import suppress
from ctypes import CDLL, c_long
from pathlib import Path

import control
import numpy as np
from scipy import signal

import zoh

SAMPLES = 500
POINTS = 2000
KEYS = ("dt", "plant.num.0", "plant.den.1", "wc", "pm_deg", "ki")
FIGURES = (
    "gain_margin", "phase_crossover", "phase_margin_deg", "crossover", "delay_margin",
    "modulus_margin", "ms", "mt", "disk_margin", "bandwidth", "overshoot_pct", "rise_time",
    "settling_time", "peak", "peak_time", "steady_state_error", "peak_effort",
    "between.overshoot_pct", "between.peak_time",
)  # fmt: skip


def by_control(design: zoh.Verified) -> None:
    """Let python-control sample the plant and measure the loop."""
    dt = design.dt
    sampled = control.c2d(control.tf(design.plant.num, design.plant.den), dt, "zoh")
    law = control.tf(design.controller.num, design.controller.den, dt)
    control.stability_margins(law * sampled)
    t = np.arange(SAMPLES) * dt
    with suppress(IndexError):  # what it raises where 500 samples do not reach 10 %
        control.step_info(control.feedback(law * sampled, 1), T=t)
    control.step_response(control.feedback(law, sampled), T=t)


def by_scipy(design: zoh.Verified) -> tuple[float, ...]:
    """Let SciPy sample the plant; margins and metrics are read off its points, to their spacing."""
    dt, law = design.dt, design.controller
    num, den, _ = signal.cont2discrete((design.plant.num, design.plant.den), dt, "zoh")
    top = np.polymul(np.ravel(num), law.num)
    bottom = np.polymul(den, law.den)
    with np.errstate(all="ignore"):  # the pole at z = 1 is the first point
        w, loop = signal.freqz(np.pad(top, (len(bottom) - len(top), 0)), bottom, POINTS)
    gain, turn = np.abs(loop[1:]), np.unwrap(np.angle(loop[1:]))
    crossover = np.argmax(gain < 1)
    margins = turn[crossover], 1 / gain[np.argmax(turn < -np.pi)], w[crossover] / dt
    worst = np.abs(1 + loop[1:]).min()
    closed = np.polyadd(top, bottom)
    steps = np.ones(SAMPLES)
    y = signal.lfilter(np.pad(top, (len(closed) - len(top), 0)), closed, steps)
    effort = signal.lfilter(np.polymul(den, law.num), closed, steps)
    out = np.nonzero(np.abs(y - 1) > 0.02)[0][-1]
    return (*margins, worst, y.max(), effort.max(), out, np.argmax(y > 0.9) - np.argmax(y > 0.1))


def octave_us(designs: list[zoh.Verified]) -> float | None:
    """Return Octave's least CPU us of a loop, told what SciPy is; None without it."""
    octave = shutil.which("octave-cli")
    if octave is None:
        return None
    loops = "".join(
        f"loops{{{i}}} = {{{list(d.plant.num)}, {list(d.plant.den)}, {list(d.controller.num)}, "
        f"{list(d.controller.den)}, {d.dt!r}}};\n"
        for i, d in enumerate(designs, 1)
    )
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "loops.m"
        script.write_text(_OCTAVE.replace("LOOPS", loops))
        done = subprocess.run([octave, str(script)], capture_output=True, text=True, check=False)
    return float(done.stdout) if done.returncode == 0 else None


_OCTAVE = f"""1;
LOOPS
least = Inf;
for turn = 1:4
  begun = cputime;
  for i = 1:numel(loops)
    [num, den, above, below, dt] = loops{{i}}{{:}};
    held = expm([0 1 0; 0 -den(2) num(1); 0 0 0] * dt);
    bottom = poly(held(1:2, 1:2));
    top = conv(poly(held(1:2, 1:2) - held(1:2, 3) * [1 0]) - bottom, above);
    around = conv(bottom, below);
    closed = top + around;
    w = pi * (1:{POINTS - 1}) / {POINTS};
    z = exp(1j * w);
    gain = polyval(top, z) ./ polyval(around, z);
    turned = unwrap(arg(gain));
    crossing = find(abs(gain) < 1, 1);
    found = [turned(crossing), w(crossing) / dt, abs(gain(find(turned < -pi, 1))) .^ -1];
    worst = min(abs(1 + gain));
    y = filter(top, closed, ones(1, {SAMPLES}));
    u = filter(conv(bottom, above), closed, ones(1, {SAMPLES}));
    found = [max(y), max(u), find(abs(y - 1) > 0.02, 1, "last"), find(y > 0.9, 1)];
  end
  least = min(least, (cputime - begun) / numel(loops) * 1e6);
end
printf("%.17g", least);
"""


class Floor:
    """``floor.c``, compiled for this machine; ``columns`` in, rows of ``FIGURES`` out."""

    def __init__(self, columns: dict[str, np.ndarray]) -> None:
        self._columns = [np.ascontiguousarray(columns[key]) for key in KEYS]
        self.figures = np.zeros((len(self._columns[0]), len(FIGURES)))
        source = Path(__file__).with_name("floor.c")
        with tempfile.TemporaryDirectory() as folder:
            library = Path(folder) / "floor.so"
            command = ["gcc", "-O3", "-march=native", "-shared", "-fPIC", source, "-o", library]
            subprocess.run([*command, "-lm"], check=True)
            self._run = CDLL(str(library)).floor_of
        array = np.ctypeslib.ndpointer(np.float64, flags="C")
        self._run.argtypes, self._run.restype = [c_long, *[array] * 7], None

    def run(self) -> None:
        self._run(len(self.figures), *self._columns, self.figures)

    def check(self, found: dict[str, np.ndarray]) -> None:
        """Raise AssertionError where a figure is not zoh's: an answer that is wrong is no floor."""
        assert (found["reason"] == 0).all()
        for name, ours in zip(FIGURES, self.figures.T, strict=True):
            np.testing.assert_allclose(ours, found[name], rtol=1e-9, atol=1e-10, err_msg=name)
