import pytest

yade = pytest.importorskip("yade", reason="these tests need YADE: run scripts/test")


@pytest.fixture(autouse=True)
def empty_scene():
    """Every test starts from a scene without bodies, engines and materials."""
    yade.O.reset()
    yield
    yade.O.reset()
