"""What `cmake --install` puts under a prefix: a package that plain python3 and YADE load without the repository."""

import os
import pathlib
import shutil
import subprocess
import sys

import pytest

BUILD = pathlib.Path(__file__).parents[1] / "build"


@pytest.mark.skipif(not shutil.which("cmake") or not (BUILD / "cmake_install.cmake").exists(), reason="needs cmake and the build folder")
def test_installed_package_is_found_and_whole(tmp_path):
    """F28: nothing was installed."""
    subprocess.run(["cmake", "--install", BUILD, "--prefix", tmp_path], check=True, capture_output=True, timeout=60)
    site = tmp_path / "lib" / f"python3.{sys.version_info.minor}" / "dist-packages"
    yade = [path for path in sys.path if path.endswith("/py") and (pathlib.Path(path) / "yade").is_dir()]
    code = "import sys, rcr; print(rcr.__file__); print(rcr.solve.__module__); print(rcr.info()['plugin'])"
    for before in ("", "import yade; ") if yade else ("",):
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(site), *yade])}
        done = subprocess.run([sys.executable, "-c", before + code], capture_output=True, text=True, timeout=60, cwd=tmp_path, env=environment)
        assert done.returncode == 0, done.stderr
        assert str(site / "rcr" / "__init__.py") in done.stdout
        assert ("for YADE" in done.stdout) == bool(before)
