"""The installed package loads in plain python3 and YADE; or the analysis alone is installed."""

import fnmatch
import importlib.util
import json
import os
import pathlib
import re
import shutil
import sys
import zipfile

import common
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUILD = ROOT / "build"
SITE = f"lib/python3.{sys.version_info.minor}/dist-packages"
needs_cmake = pytest.mark.skipif(not shutil.which("cmake"), reason="needs cmake")
needs_build = pytest.mark.skipif(
    not shutil.which("cmake") or not (BUILD / "cmake_install.cmake").exists(),
    reason="needs cmake and the build folder")
needs_pip = pytest.mark.skipif(
    not all(map(importlib.util.find_spec, ("pip", "scikit_build_core"))),
    reason="needs pip and scikit-build-core")


def without_yade(folder, *arguments, **environment):
    """Output of CMake for a folder of build files. CMake finds no headers of YADE there."""
    return cmake("-G", "Ninja", "-S", ROOT, "-B", folder, "-DRCR_PLUGIN=AUTO",
                 f"-DYADE_SOURCE_DIR={folder}", f"-DPython3_EXECUTABLE={sys.executable}",
                 *arguments, **environment)


def cmake(*arguments, **environment):
    return common.ended("cmake", *arguments, env=os.environ | environment).stdout


def python(code, folder, *path, returncode=0):
    """stdout and stderr of Python code in a folder, with this path of modules."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, path))}
    done = common.python(code, cwd=folder, env=environment, code=returncode)
    return done.stdout + done.stderr


@needs_build
def test_installed_package_is_found_and_whole(tmp_path):
    cmake("--install", BUILD, "--prefix", tmp_path)
    site = tmp_path / SITE
    yade = [path for path in sys.path if path.endswith("/py")
            and (pathlib.Path(path) / "yade").is_dir()]
    code = "import rcr; print(rcr.__file__, rcr.solve.__module__, rcr.info()['plugin'])"
    for before in ("", "import yade; ") if yade else ("",):
        told = python(before + code, tmp_path, site, *yade)
        assert str(site / "rcr" / "__init__.py") in told
        assert ("for YADE" in told) == bool(before)
    modules = [{path.relative_to(folder) for path in (folder / "rcr").rglob("*.py")}
               for folder in (site, ROOT / "py")]
    assert modules[0] == modules[1]


@needs_build
def test_debians_own_folder_under_usr(tmp_path):
    cmake("--install", BUILD, "--prefix", "/usr", DESTDIR=str(tmp_path))
    assert (tmp_path / "usr/lib/python3/dist-packages/rcr/__init__.py").exists()
    examples = [{path.relative_to(folder) for path in folder.rglob("*.*")
                 if path.suffix in (".py", ".table", ".ipynb")}
                for folder in (tmp_path / "usr/share/doc/yade-rcr/examples", ROOT / "examples")]
    assert examples[0] == examples[1]


@needs_build
def test_jupyter_finds_the_kernel_of_the_package(tmp_path):
    """Its Python imports YADE from the folder that YADE's own program uses."""
    cmake("--install", BUILD, "--prefix", tmp_path)
    kernel = json.loads((tmp_path / "share/jupyter/kernels/yade/kernel.json").read_text())
    program, *options = kernel["argv"]
    assert options == ["-m", "ipykernel_launcher", "-f", "{connection_file}"]
    folder = kernel["env"]["PYTHONPATH"].removesuffix(":${PYTHONPATH}")
    code = "from yade import *; from rcr import *; print(ContactDynamics())"
    environment = os.environ | {"PYTHONPATH": f"{folder}:{tmp_path / SITE}"}
    assert "<ContactDynamics instance" in common.ended(program, "-c", code, env=environment).stdout


@pytest.fixture
def own_yade(tmp_path):
    """Writes the configuration of a YADE in tmp_path, whose sources are there too."""
    config = tmp_path / "lib" / "yade-1.2" / "py" / "yade" / "config.py"
    for file in (config, tmp_path / "core" / "Scene.hpp"):
        file.parent.mkdir(parents=True)
        file.touch()
    (tmp_path / "RELEASE").write_text("1.2\n")

    def write(version="1.2", features=()):
        config.write_text(f"version, features = '{version}', {list(features)}\n"
                          "highPrecisionBits, highPrecisionDecimalPlaces = 64, 15\n")
        return ("cmake", "-G", "Ninja", "-S", ROOT, "-B", tmp_path / "build",
                f"-DYADE_PREFIX={tmp_path}", f"-DYADE_SOURCE_DIR={tmp_path}")
    return write


@needs_build
def test_headers_of_another_version_are_refused(own_yade):
    assert "has version 1.2, the installed YADE has 1.1" in " ".join(
        common.ended(*own_yade("1.1"), code=1).stderr.split())


@needs_build
@pytest.mark.skipif(not shutil.which("git"), reason="needs git")
def test_headers_of_a_checkout_are_taken_with_a_warning(own_yade, tmp_path):
    """A checkout may have no file with its version."""
    (tmp_path / "RELEASE").unlink()
    author = "-c", "user.name=A", "-c", "user.email=a@b"
    for command in ["init"], [*author, "commit", "--allow-empty", "-m", "first"]:
        common.ended("git", "-C", tmp_path, *command)
    told = " ".join(common.ended(*own_yade("1.2")).stderr.split())
    assert "the installed YADE is the release 1.2" in told
    built_elsewhere = own_yade("2020-01-02.git-1234567")
    assert "has version" in " ".join(common.ended(*built_elsewhere, code=1).stderr.split())


@needs_build
def test_features_of_a_yade_of_the_user_are_defined(own_yade, tmp_path):
    """They change the layouts of classes."""
    for features, defined in [("LOGGER", {"YADE_BOOST_LOG", "EIGEN_DONT_ALIGN"}),
                              ("VECTORIZE PROFILING", {"USE_TIMING_DELTAS"}),
                              ("FAST_NATIVE", {"EIGEN_DONT_ALIGN"})]:
        common.ended(*own_yade(features=features.split()))
        ninja = (tmp_path / "build" / "build.ninja").read_text()
        words = "YADE_BOOST_LOG", "USE_TIMING_DELTAS", "EIGEN_DONT_ALIGN"
        assert {word for word in words if f"-D{word}" in ninja} == defined


@needs_cmake
def test_analysis_alone_without_compiler(tmp_path):
    """pip takes this path where YADE and a compiler are missing."""
    told = without_yade(tmp_path / "build", CXX="/none")
    assert "Nothing is compiled" in told
    cmake("--build", tmp_path / "build")
    cmake("--install", tmp_path / "build", "--prefix", tmp_path)
    site = tmp_path / SITE
    assert not list(site.rglob("*.so"))
    assert str(site) in python("import rcr, rcr.plot, rcr.measure, rcr.study.analysis; "
                               "print(rcr.Network, rcr.__file__)", tmp_path, site)
    told = python("""
import rcr
try:
    rcr.solve("problem.npz")
except ImportError as error:
    print(error)
""", tmp_path, site)
    assert "has no kernels, only the analysis: the solver has to be compiled" in told


@needs_build
def test_solver_alone_outside_the_clone(tmp_path):
    """pip takes this path where YADE is missing; it must not replace scripts/yade-rcr's modules."""
    told = without_yade(tmp_path, "-DSKBUILD=2")
    assert "The solver is compiled without YADE" in told
    modules = re.findall(r"^build (\S+\.so)\b", (tmp_path / "build.ninja").read_text(), re.M)
    assert modules and not [path for path in modules if path.startswith(str(ROOT))]


def wheel(folder, **environment):
    """A wheel that pip makes without network and without YADE's headers."""
    common.ended(sys.executable, "-m", "pip", "wheel", "--no-build-isolation", "--no-deps",
                 "--no-index", f"--config-settings=cmake.define.YADE_SOURCE_DIR={folder}",
                 "-w", folder, ROOT, cwd=folder, env=os.environ | environment)
    (path,) = folder.glob("*.whl")
    return path


@needs_pip
def test_wheel_has_the_package_alone(tmp_path):
    with zipfile.ZipFile(wheel(tmp_path, CXX="/none")) as made:
        names = {name for name in made.namelist() if ".dist-info/" not in name}
    source = ROOT / "py"
    assert names == {str(path.relative_to(source)) for path in source.rglob("*.py")}


@needs_pip
@pytest.mark.slow
def test_wheel_with_the_solver_is_used_without_yade(tmp_path):
    made = wheel(tmp_path)
    common.ended(sys.executable, "-m", "pip", "install", "--no-deps", "--no-index", "--target",
                 tmp_path / "site", made)
    code = f"""
import rcr
found = rcr.solve({str(ROOT / "tests/data/shear-500-eta-0.7.npz")!r})
print(rcr.__file__, found.converged)
"""
    assert python(code, tmp_path, tmp_path / "site").split() == [
        str(tmp_path / "site" / "rcr" / "__init__.py"), "True"]


def test_the_container_takes_what_the_clone_has():
    """Its context has all sources, its commands are those of the page, and its port too."""
    text, page = (ROOT / "Containerfile").read_text(), (ROOT / "docs/installation.md").read_text()
    ignored = (ROOT / ".dockerignore").read_text().split()
    sources = [words[-2] for words in map(str.split, re.findall("^COPY (.*)", text, re.M))]
    assert sources == [".", "/yade-rcr/build/yade-rcr_*.deb", "examples/notebooks"]
    assert (ROOT / sources[2]).is_dir() and "WORKDIR /yade-rcr\n" in text
    needed = "CMakeLists.txt", "LICENSE", "cmake", "examples", "pkg", "py", "scripts"
    assert all((ROOT / name).exists() for name in needed)
    assert not [name for name in needed for pattern in ignored if fnmatch.fnmatch(name, pattern)]
    made, run = re.findall(r"^RUN (scripts/.*)|^CMD \[\"(\S+)\"", text, re.M)
    assert made[0] in page and run[1] == "jupyter-lab"
    (port,) = re.findall(r"^EXPOSE (\d+)$", text, re.M)
    assert set(re.findall(r"-p (\d+):(\d+)", text + page)) == {(port, port)}


@needs_cmake
def test_one_version(tmp_path):
    cmake("-G", "Ninja", "-S", ROOT, "-B", tmp_path, "-DRCR_PLUGIN=AUTO",
          f"-DYADE_SOURCE_DIR={tmp_path}")
    (version,) = re.findall(r"^CMAKE_PROJECT_VERSION:STATIC=(.*)$",
                            (tmp_path / "CMakeCache.txt").read_text(), re.M)
    assert python("import rcr; print(rcr.__version__)", tmp_path, ROOT / "py").strip() == version
    assert not re.search(r"^version\b", (ROOT / "pyproject.toml").read_text(), re.M)
    assert re.findall(r"^version: (.*)$", (ROOT / "CITATION.cff").read_text(), re.M) == [version]


def test_without_its_plugin_rcr_says_so_to_yade(tmp_path):
    shutil.copytree(ROOT / "py" / "rcr", tmp_path / "rcr",
                    ignore=shutil.ignore_patterns("*.so", "__pycache__"))
    code = "import sys, types; sys.modules['yade'] = types.ModuleType('yade'); import rcr"
    assert ("has no plugin for YADE, only the analysis; run scripts/yade-rcr"
            in python(code, tmp_path, tmp_path, returncode=1))
