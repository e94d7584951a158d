"""rcr loads its plugin into the YADE that it finds, so YADE comes first. Kernels and analysis are tested without one too."""

import importlib.util
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # scenes are tiny: a team of threads costs more than it gives

if importlib.util.find_spec("yade"):
    import yade
