"""What all tests share: one BLAS thread, no display, and a hypothesis profile that is the same in every run."""

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")

from hypothesis import settings  # noqa: E402

settings.register_profile("same", derandomize=True, deadline=None, database=None)
settings.load_profile("same")
