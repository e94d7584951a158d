"""The Python blocks of each page run as one YADE script; the page on laws gives a working law."""

import pathlib
import re
import shlex
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = ROOT / "build"
PAGES = [page for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
         if "```python\n" in page.read_text()]


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text(), re.M | re.S)


def run(page, folder, before=""):
    """Return the output of a page's script, which must end well."""
    script = folder / f"{page.stem}.py"
    script.write_text(before + "\n".join(blocks(page, "python")))
    done = subprocess.run(["yade", "-n", "-x", script.name], cwd=folder, capture_output=True,
                          text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.mark.parametrize("page", [page for page in PAGES if page.stem != "extending"],
                         ids=lambda page: page.stem)
def test_page(page, tmp_path):
    assert "Traceback" not in run(page, tmp_path)


def compile_command(source, folder):
    """The build's compile command of a plugin file, for another source."""
    listed = subprocess.run(["ninja", "-C", BUILD, "-t", "commands", "_plugin"],
                            capture_output=True, text=True, check=True).stdout
    line = next(line for line in listed.splitlines() if "/_plugin.dir/Unity/" in line
                and " -c " in line)
    words = shlex.split(line)
    words = words[: words.index("-c")] + ["-c", str(source)]
    for option in ("-o", "-MF", "-MT"):
        if option in words:
            words[words.index(option) + 1] = str(folder / f"law{option}")
    return words, folder / "law-o"


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("ninja") or not (BUILD / "build.ninja").exists(),
                    reason="needs the build folder")
def test_law_of_the_page(tmp_path):
    """Compiled with the build's options and loaded before rcr; the build's files stay."""
    page = ROOT / "docs" / "extending.md"
    (law,) = blocks(page, "cpp")
    assert len(law.splitlines()) < 60
    (name,) = re.findall(r"Put this into `(pkg/dem/[\w/]+\.cpp)`", page.read_text())
    source = tmp_path / pathlib.Path(name).name
    source.write_text(law)
    command, compiled = compile_command(source, tmp_path)
    subprocess.run(command, cwd=BUILD, check=True, timeout=3600)
    (plugin,) = (ROOT / "py" / "rcr").glob("_plugin*.so")
    subprocess.run([command[0], "-shared", "-o", tmp_path / "law.so", compiled, plugin,
                    f"-Wl,-rpath,{plugin.parent}"], check=True, timeout=120)
    before = f"import ctypes; ctypes.CDLL('{tmp_path}/law.so', ctypes.RTLD_GLOBAL)\n"
    assert "Traceback" not in run(page, tmp_path, before)
