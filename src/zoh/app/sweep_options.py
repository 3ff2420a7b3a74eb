"""The options of ``zoh sweep``, apart from what it runs with: other commands do not wait for it."""

from argparse import ArgumentParser


def declare(parser: ArgumentParser) -> None:
    """Add the options of ``zoh sweep`` to its parser."""
    add = parser.add_argument
    add(
        "--over", metavar="KEY=FROM:TO:N", nargs="+", action="extend", required=True,
        help="what varies: wc=1:3:21, dt=1e-3:1e-1:9:log, ki=1,2,5; for a sample or corners "
        "plant.gain=2:3, plant.gain=2:3:log, plant.gain=2.5~0.1; plant.gain is num[0]/den[0], "
        "0.2 of 2/(10 s + 1)",
    )  # fmt: skip
    add("--sample", metavar="N", type=int, help="N random loops instead of a grid")
    add("--seed", metavar="S", type=int, help="the same seed, the same sample (0)")
    add("--latin", action="store_true", help="the sample is a Latin hypercube")
    add("--corners", action="store_true", help="the ends of every interval")
    add(
        "--controller", metavar="NAME", action="append", default=[],
        help="only this controller of the file; may be repeated",
    )  # fmt: skip
    add(
        "--fixed", action="store_true",
        help="design each controller once, on the plant as it stands, and keep it as it is",
    )  # fmt: skip
    add(
        "--out", metavar="FILE",
        help="write every loop to FILE.nc, or to FILE.zarr, which goes on where it was ended",
    )  # fmt: skip
    add("--figures", metavar="DIR", help="draw maps or bands there")
    add("--force", action="store_true", help="let --figures replace files")
    add("--scheduler", metavar="ADDRESS", help="let the workers of a Dask scheduler do the work")
    add("--arithmetic", metavar="NAME", help="compute it this way; chosen where left out")
