import pathlib
import sys

import pytest

sys.path.append(str(pathlib.Path(__file__).parents[1] / "endurance"))

yade = sys.modules.get("yade")  # ../conftest.py imports it where it is installed
if yade is None:
    collect_ignore_glob = ["*"]


@pytest.fixture(autouse=True)
def empty_scene():
    yade.O.reset()
    yield
    yade.O.reset()
