"""rcr loads its plugin into the YADE that it finds, so YADE comes first. Kernels and analysis are tested without one too."""

import importlib.util
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # scenes are tiny: a team of threads costs more than it gives

if importlib.util.find_spec("yade"):
    import yade

if importlib.util.find_spec("hypothesis"):
    import hypothesis

    # the same examples in every run, and no verdict on the speed of a machine that does other things too
    slow = [hypothesis.HealthCheck.too_slow]
    hypothesis.settings.register_profile("steady", deadline=None, derandomize=True, suppress_health_check=slow)
    hypothesis.settings.load_profile("steady")
