"""Sweeps measured: one thread of BLAS for everybody, said before NumPy is loaded.

A second one waits for products of 5 by 5 numbers in a busy loop, and its time was counted as
python-control's.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
