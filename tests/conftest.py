"""Imports YADE before rcr, which loads its plugin into it, where both are there."""

import importlib.util
import os
import pathlib

# threads cost more than they give in tiny scenes
os.environ.setdefault("OMP_NUM_THREADS", "1")

RCR = importlib.util.find_spec("rcr")
if not (RCR and any(pathlib.Path(RCR.origin).parent.glob("_plugin*.so"))):
    LEFT_OUT = "the plugin is not built; scripts/test builds it"
elif not importlib.util.find_spec("yade"):
    LEFT_OUT = "no YADE for this Python; scripts/test brings one"
else:
    import yade

    LEFT_OUT = None

if importlib.util.find_spec("hypothesis"):
    import hypothesis

    # Every run has the same examples and no deadline; `scripts/check properties` takes new ones.
    steady = hypothesis.settings(deadline=None, derandomize=True,
                                 suppress_health_check=[hypothesis.HealthCheck.too_slow])
    hypothesis.settings.register_profile("steady", steady)
    hypothesis.settings.register_profile("long", steady, derandomize=False, max_examples=1000)
    hypothesis.settings.load_profile("steady")


def pytest_report_header():
    return f"tests/yade is left out: {LEFT_OUT}" if LEFT_OUT else None
