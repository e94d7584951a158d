"""The set-up's logic: the real scripts of scripts/lib on a machine made of stand-ins.

Each test has a temporary cache, a temporary /etc and a PATH with the plain tools of any system
and stand-ins for what would touch the network or the machine: apt-get, dpkg-query, mmdebstrap,
bwrap, id, df, uname. A stand-in writes its arguments to `calls`.
"""

import os
import re
import shutil
import signal
import subprocess
from pathlib import Path

import pytest
from common import wait_until

REPOSITORY = Path(__file__).resolve().parent.parent
TOOLS = """awk basename bash bzip2 cat chmod cp cut date dirname echo env find flock getent grep
    head ln ls mkdir mktemp mv nproc paste printf readlink realpath rm rmdir sed seq sh sha256sum
    sleep sort tail tar tee touch tr true wc""".split()


# A root file system as small as it goes, written as the archive that mmdebstrap would write.
SMALL_ROOT = """
work=$(mktemp -d)
mkdir -p $work/usr/src/yade/core $work/usr/bin $work/usr/lib/x/yade-double/py
mkdir -p $work/etc/ssl/certs $work/var
echo root >$work/usr/bin/python3
ln -s usr/bin $work/bin
tar -c -C $work .
"""


def last_line(errors):
    return errors.strip().splitlines()[-1]


class Machine:
    """A machine for one test: add stand-ins, then run shell code with environment.sh sourced."""

    def __init__(self, path):
        self.path, self.cache = path, path / "cache" / "yade-rcr"
        self.bin, self.etc, self.repo, self.calls = map(path.joinpath, "bin etc repo calls".split())
        for directory in (self.bin, self.etc, self.repo / "py"):
            directory.mkdir(parents=True)
        shutil.copytree(REPOSITORY / "scripts" / "lib", self.repo / "scripts" / "lib")
        for tool in TOOLS:
            (self.bin / tool).symlink_to(shutil.which(tool))
        self.calls.touch()
        (self.etc / "subuid").write_text("alice:100000:65536\n")
        self.debian("trixie")
        self.user("alice", 1000)
        self.command("uname", "echo x86_64")
        self.free(50)

    def command(self, name, body):
        """A stand-in: `body` is shell code."""
        file = self.bin / name
        file.unlink(missing_ok=True)
        file.write_text(f'#!/bin/sh\necho "{name} $*" >>{self.calls}\n{body}\n')
        file.chmod(0o755)

    def debian(self, codename):
        (self.etc / "os-release").write_text(f"ID=debian\nVERSION_CODENAME={codename}\n")

    def user(self, name, number):
        self.command("id", f'case $1 in -un) echo {name} ;; *) echo {number} ;; esac')

    def free(self, gigabytes):
        self.command("df", f'echo head; echo "disk 0 0 {gigabytes * 2**20} 0% /"')

    def installed(self, version="2025.2.0-1"):
        """Every package is installed, YADE in the given version."""
        self.command("dpkg-query", f'case "$*" in *ource:Version*) echo {version} ;; *) echo '
                     f'installed ;; esac')
        self.offers(version)

    def offers(self, version):
        """apt knows this version of YADE and of its source."""
        self.command("apt-cache", f'case "$*" in *policy*) echo "  Candidate: {version}" ;; '
                     f'*) echo "Version: {version}" ;; esac')

    def archive(self, version):
        """apt-get delivers YADE's source archive, and nothing else."""
        source = self.path / "trunk" / "core"
        source.mkdir(parents=True)
        (source / "Scene.hpp").write_text("// YADE\n")
        tar = self.path / f"yade_{version}.orig.tar.bz2"
        subprocess.run(["tar", "-cjf", tar, "-C", self.path, "trunk"], check=True)
        self.command("apt-get", f'case "$*" in *" source "*) cp {tar} . ;; esac')

    def root_tools(self, mmdebstrap=SMALL_ROOT):
        """The tools for a root file system, with `mmdebstrap` as the shell code of that command."""
        for name, body in (("mmdebstrap", mmdebstrap), ("bwrap", "echo 1"), ("nsenter", "exit 0"),
                           ("newuidmap", "exit 0"),
                           ("apt-config", "echo 'Acquire::Check-Valid-Until \"false\";'")):
            self.command(name, body)
        if not (self.bin / "apt-get").exists():
            self.command("apt-get", "exit 100")

    def bare(self, mmdebstrap=SMALL_ROOT):
        """Debian 12 without packages, and the tools for a root file system."""
        self.debian("bookworm")
        self.command("dpkg-query", "exit 1")
        self.root_tools(mmdebstrap)

    def start(self, code, **environment):
        return subprocess.Popen(
            ["bash", "-c", f". {self.repo}/scripts/lib/environment.sh\n{code}"],
            env={"PATH": str(self.bin), "HOME": str(self.path),
                 "XDG_CACHE_HOME": str(self.path / "cache"),
                 "YADE_RCR_ETC": str(self.etc), "YADE_RCR_USR": str(self.path),
                 "LC_ALL": "C.UTF-8", **environment},
            cwd=self.path, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True, start_new_session=True,
            # a process in the background ignores SIGINT, and so would bash
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))

    def run(self, code, **environment):
        """(exit code, standard output, standard error)"""
        process = self.start(code, **environment)
        output, errors = process.communicate(timeout=60)
        return process.returncode, output, errors

    def succeeds(self, code, prints="", **environment):
        """Run code that prints `prints`; return standard error."""
        status, output, errors = self.run(code, **environment)
        assert (status, output) == (0, prints), errors
        return errors

    def assert_sets_up(self, way):
        """Set up by this way, "native" or "rootfs"; return standard error."""
        return self.succeeds("ready; echo $way", f"{way}\n")

    def refuses(self, **environment):
        """Return the last line of standard error of a set-up that fails."""
        status, _, errors = self.run("ready", **environment)
        assert status != 0
        return last_line(errors)

    def called(self, name):
        return [line for line in self.calls.read_text().splitlines() if line.startswith(name + " ")]

    def roots(self):
        return sorted(self.cache.glob("root-*"))


@pytest.fixture
def machine(tmp_path):
    return Machine(tmp_path)


def two_at_once(machine, code, tool, work, until, **environment):
    """(output, errors) of two processes; `tool` works, then waits for `until(calls of flock)`:
    "flock -w …" in a loop, then "flock 9" after the notice.
    """
    environment["YADE_RCR_PATIENCE"] = "0.05"  # seconds
    end = machine.path / "end"
    end.unlink(missing_ok=True)
    machine.calls.write_text("")
    machine.command("flock", f'exec {shutil.which("flock")} "$@"')
    machine.command(tool, f"{work}\nuntil [ -e {end} ]; do sleep 0.01; done")
    processes = [machine.start(code, **environment) for _ in range(2)]
    try:
        wait_until(lambda: until(machine.called("flock")))
    finally:
        end.touch()
    return [process.communicate(timeout=60) for process in processes]


# Machines that lack something: one line that says what to do

def test_a_user_whose_system_has_yade_sees_the_missing_packages(machine):
    machine.offers("2025.2.0-1")
    machine.command("dpkg-query", """case "$*" in
"-W g++") exit 1 ;;
*ource:Version*) echo 2025.2.0-1 ;;
*Status*) echo installed; echo "no packages found matching g++" >&2; exit 1 ;;
esac""")
    message = machine.refuses()
    assert "apt-get install g++" in message
    assert "libyade" not in message, "only what is missing"


@pytest.mark.parametrize("break_it, words", [
    (lambda m: [(m.bin / name).unlink() for name in ("mmdebstrap", "bwrap", "newuidmap")],
     "apt-get install mmdebstrap bubblewrap uidmap"),
    (lambda m: m.command("uname", "echo riscv64"), "this is riscv64"),
    (lambda m: (m.etc / "subuid").write_text("bob:1:1\n"), "usermod --add-subuids"),
    (lambda m: m.command("bwrap", "exit 1"), "user namespaces"),
    (lambda m: m.free(2), "2 GB free"),
])
def test_an_unsuitable_machine_prints_the_reason(machine, break_it, words):
    machine.bare()
    break_it(machine)
    assert words in machine.refuses()
    assert not machine.called("mmdebstrap")


@pytest.mark.parametrize("output, words", [
    ("E: Failed to fetch http://mirror/dists/trixie/InRelease  Temporary failure resolving "
     "'mirror'", "check the network"),
    ("E: Failed to fetch http://mirror/pool/main/d/dash_1_amd64.deb  404  Not Found",
     "dash_1_amd64.deb (404"),
    ("dpkg: error: No space left on device", "the disk is full"),
    ("E: something else", "E: something else"),
])
def test_a_failed_bootstrap_says_why_and_leaves_nothing(machine, output, words):
    machine.bare(f'echo "{output}" >&2; exit 1')
    message = machine.refuses()
    assert words in message and str(machine.cache / "log") in message
    assert output in (machine.cache / "log").read_text()
    assert [file.name for file in machine.cache.iterdir()] == ["log"]


# A YADE of the user

@pytest.fixture
def own_yade(machine):
    """YADE as its own build installs it, in ./own, built from ./trunk."""
    python = machine.path / "own" / "lib" / "x" / "yade-1.2" / "py" / "yade"
    for folder in (python, machine.path / "own" / "bin", machine.path / "trunk" / "core"):
        folder.mkdir(parents=True)
    (python / "config.py").write_text(f"version='1.2'\nsourceRoot='{machine.path}/trunk'\n")
    (machine.path / "trunk" / "core" / "Scene.hpp").touch()
    executable = machine.path / "own" / "bin" / "yade-1.2"
    executable.write_text('#!/bin/sh\necho "own YADE $*: $PYTHONPATH"\n')
    executable.chmod(0o755)
    return machine


def test_a_yade_of_the_user_needs_no_set_up(own_yade):
    python = f"{own_yade.repo}/py:{own_yade.path}/own/lib/x/yade-1.2/py:{own_yade.repo}"
    own_yade.succeeds("ready; enter yade -n", f"own YADE -n: {python}\n", YADE_PREFIX="own")
    # a script that starts another one
    inner = f". {own_yade.repo}/scripts/lib/environment.sh; ready; enter yade"
    assert "own YADE" in own_yade.run(f"ready; enter bash -c '{inner}'", YADE_PREFIX="own")[1]
    assert not own_yade.called("apt-get")


def test_a_yade_of_the_user_is_built_with_its_sources(own_yade):
    own_yade.command("cmake", 'echo "prefix $YADE_PREFIX"')
    for changed in "", "# another feature\n":
        with open(own_yade.path / "own/lib/x/yade-1.2/py/yade/config.py", "a") as file:
            file.write(changed)
        own_yade.calls.write_text("")
        own_yade.succeeds("ready; build", YADE_PREFIX="own")
        assert own_yade.called("cmake")[0].endswith(f"-DYADE_SOURCE_DIR={own_yade.path}/trunk")


def test_a_wrong_prefix_is_refused(own_yade):
    assert "none has no lib/yade*/py/yade" in own_yade.refuses(YADE_PREFIX="none")
    shutil.rmtree(own_yade.path / "trunk")
    assert "set YADE_SOURCE_DIR" in own_yade.refuses(YADE_PREFIX="own")


# Native

@pytest.mark.parametrize("version", ["2022.01a", "2023.02a", "2025.2.0", "2026.1.0"])
def test_native_takes_the_headers_of_the_installed_yade_once(machine, version):
    machine.debian("forky")
    machine.installed(f"{version}-3build1")
    machine.archive(version)
    source = machine.cache / f"source-{version}"
    machine.succeeds("ready; echo $way; native_source", f"native\n{source}\n")
    assert any(f"yade={version}-3build1" in call for call in machine.called("apt-get"))
    assert (source / "core" / "Scene.hpp").exists() and not list(machine.cache.glob("new.*"))
    machine.command("apt-get", "exit 1")
    machine.calls.write_text("")
    assert machine.succeeds("ready") == ""
    assert not machine.called("apt-get"), "no network once it is set up"


def test_root_installs_nothing_if_usr_is_read_only(machine):
    """So it is in a root file system, whose /var is that of the machine."""
    machine.user("root", 0)
    machine.offers("2025.2.0-1")
    machine.archive("2025.2.0")
    machine.command("dpkg-query", "exit 1")
    assert "mmdebstrap bubblewrap" in machine.refuses(YADE_RCR_USR=str(machine.path / "none"))
    assert not machine.called("apt-get")


def test_native_keeps_the_headers_when_a_package_is_reinstalled(machine):
    machine.user("root", 0)
    machine.offers("2025.2.0-1")
    machine.command("apt-get", 'case "$*" in *" install "*) touch installed ;; '
                    '*" source "*) exit 1 ;; esac')
    machine.command("dpkg-query", f'cd {machine.path}; [ -e installed ] || exit 1; case "$*" in '
                    '*ource:Version*) echo 2025.2.0-1 ;; *) echo installed ;; esac')
    (machine.cache / "source-2025.2.0").mkdir(parents=True)
    machine.assert_sets_up("native")


def test_without_the_archive_or_with_an_older_yade_a_root_file_system_is_taken(machine):
    machine.installed()
    machine.root_tools()
    assert "source archive" in machine.assert_sets_up("rootfs")
    machine.installed("2021.01a-4")
    machine.archive("2021.01a")
    shutil.rmtree(machine.roots()[0])
    machine.assert_sets_up("rootfs")


def test_headers_that_the_user_names_replace_a_root_file_system(machine):
    machine.root_tools()
    machine.assert_sets_up("rootfs")
    machine.installed("2023.02a-1")
    machine.succeeds("ready; echo $way", "rootfs\n")
    machine.calls.write_text("")
    (machine.path / "core").mkdir()
    (machine.path / "core" / "Scene.hpp").touch()
    machine.succeeds("ready; echo $way; native_source", f"native\n{machine.path}\n",
                     YADE_SOURCE_DIR=str(machine.path))
    assert not machine.called("apt-get")
    assert "none has no core/Scene.hpp" in machine.refuses(YADE_SOURCE_DIR=f"{machine.path}/none")


def test_without_headers_no_package_is_installed(machine):
    machine.user("root", 0)
    machine.bare()
    machine.offers("2023.02a-1")
    machine.command("apt-get", 'case "$*" in *" source "*) exit 100 ;; esac')
    _, _, errors = machine.run("ready")
    assert "no source archive of YADE 2023.02a found (YADE_SOURCE_DIR=FOLDER names one)" in errors
    assert not any("python3-yade" in call for call in machine.called("apt-get"))


# The root file system

def interrupted(machine, number):
    """Exit code of a set-up that gets this signal while it makes a root file system."""
    machine.calls.write_text("")
    machine.bare("exec sleep 60")
    process = machine.start("ready")
    wait_until(lambda: machine.called("mmdebstrap"))
    os.killpg(process.pid, number)
    process.communicate(timeout=60)
    return process.returncode


def test_a_root_file_system_is_complete_or_not_there(machine):
    assert interrupted(machine, signal.SIGINT) == 130
    assert [file.name for file in machine.cache.iterdir()] == ["log"]
    interrupted(machine, signal.SIGKILL)
    assert not machine.roots()
    assert list(machine.cache.glob("new.*")), "the interrupted one's leftovers"
    machine.root_tools()
    machine.assert_sets_up("rootfs")
    assert len(machine.roots()) == 1 and not list(machine.cache.glob("new.*"))
    shutil.rmtree(machine.roots()[0])  # belongs to the user, so this is all it takes


def test_mmdebstrap_inherits_no_open_files(machine):
    """It passes numbers of files to a shell that knows only numbers up to 9."""
    machine.bare(f"for n in 3 4 5 6 7 8 9; do [ ! -e /proc/$$/fd/$n ] || exit 1; done {SMALL_ROOT}")
    machine.assert_sets_up("rootfs")


def test_a_changed_package_list_makes_another_root(machine):
    machine.bare()
    machine.succeeds("ready")
    packages = machine.repo / "scripts" / "lib" / "setup" / "packages"
    text = packages.read_text()
    for changed, roots in ("# a comment changes nothing\n" + text, 1), (text + "hello\n", 2):
        packages.write_text(changed)
        machine.run("ready")
        assert len(machine.roots()) == roots, changed


def test_a_complete_root_is_kept_when_bubblewrap_was_removed(machine):
    machine.bare()
    machine.succeeds("ready")
    (machine.bin / "bwrap").unlink()
    machine.user("root", 0)
    machine.command("apt-get", f'printf "#!/bin/sh\\necho 1\\n" >{machine.bin}/bwrap; chmod +x '
                    f'{machine.bin}/bwrap')
    machine.assert_sets_up("rootfs")
    assert len(machine.called("mmdebstrap")) == 1
    assert not (machine.roots()[0] / "root").exists()


def test_a_second_set_up_waits_for_the_first(machine):
    machine.bare()
    results = two_at_once(machine, "ready; echo $way", "mmdebstrap", SMALL_ROOT,
                          lambda flocks: "flock 9" in flocks)
    assert [output for output, _ in results] == ["rootfs\n"] * 2, results
    assert sum("waiting for another set-up" in errors for _, errors in results) == 1
    assert len(machine.called("mmdebstrap")) == 1


def test_mirrors_come_from_the_apt_sources(machine):
    machine.debian("bookworm")
    machine.command("apt-get", """cat <<END
bookworm main http://one/debian/
bookworm-updates main http://one/debian/
bookworm-security main http://two/security/
bookworm contrib http://one/debian/
stable main http://three/debian/
bookworm-tool main http://tool/
END""")
    _, output, errors = machine.run("rootfs_mirrors")
    assert output.splitlines() == [
        "deb http://one/debian/ trixie main;deb http://one/debian/ trixie-updates main;"
        "deb http://three/debian/ trixie main;deb http://two/security/ trixie-security main;",
        "deb http://one/debian/ trixie main",
        "deb http://three/debian/ trixie main",
        "",
    ], errors
    (machine.etc / "os-release").write_text("ID=ubuntu\nVERSION_CODENAME=noble\n")  # no Debian
    machine.command("apt-get", "echo noble main http://ubuntu/")
    assert machine.run("rootfs_mirrors")[1] == "\n"


def test_the_next_mirror_is_tried(machine):
    machine.command("apt-get", "echo bookworm main http://one/debian/; echo bookworm-updates main "
                    "http://one/debian/")
    missing = "E: Failed to fetch http://one/debian/pool/dash_1_amd64.deb  404  Not Found"
    machine.bare(f'case "$*" in *updates*) echo "{missing}" >&2; exit 1 ;; esac {SMALL_ROOT}')
    assert "dash_1_amd64.deb (404" in machine.assert_sets_up("rootfs")
    assert len(machine.called("mmdebstrap")) == 2


# Entering it

@pytest.fixture
def entered(machine):
    """Run a command in a small root file system; return the bind options of bubblewrap in order."""
    machine.bare()

    def enter(*arguments):
        machine.calls.write_text("")
        machine.succeeds(f"ready; enter {' '.join(arguments)}")
        command = machine.called("nsenter")[-1].split()
        binds = machine.called("bwrap")[-1].split()
        return command, {binds[i + 2] for i, word in enumerate(binds)
                         if word in ("--bind", "--dev-bind")}

    return enter


def test_the_command_takes_the_place_of_the_script(machine):
    """Its process is that of the script, and so are signals; no other process remains."""
    machine.bare()
    machine.succeeds("ready")
    becomes = 'while [ "$1" != sh ]; do shift; done; exec "$@"'  # without another root
    for name in "bwrap", "nsenter":
        machine.command(name, becomes.replace("exec", "echo $$ >>holder; exec"))
    code = """trap 'echo stopped; exit 3' TERM; echo $$; while :; do sleep 0.1; done"""
    process = machine.start('ready; enter sh -c "$CODE"', CODE=code)
    assert process.stdout.readline() == f"{process.pid}\n"
    holder, own = map(int, (machine.path / "holder").read_text().split())
    assert own == process.pid
    wait_until(lambda: not os.path.exists(f"/proc/{holder}/root"))  # a zombie has none
    process.terminate()
    assert process.communicate(timeout=60)[0] == "stopped\n" and process.returncode == 3


def test_an_error_of_bubblewrap_is_one_line(machine):
    machine.bare()
    machine.succeeds("ready")
    machine.command("bwrap", "echo 'bwrap: no space' >&2; exit 1")
    code, output, errors = machine.run("ready; enter true")
    assert (code, output) == (1, "") and errors == (
        "yade-rcr: bubblewrap cannot make the root file system: bwrap: no space\n")


def test_every_directory_of_the_machine_is_there_but_usr_and_etc(entered):
    """A bind keeps the files of the root, also beside a mount point, /usr/include/linux."""
    call, bound = entered("python3", "scene.py")
    own = {"/usr", "/etc", "/bin"}  # of the small root
    visible = {str(path) for path in Path("/").glob("[!.]*") if path.is_dir()}
    assert bound >= visible - own
    assert not bound & own
    assert call[-2:] == ["python3", "scene.py"]
    entered("python3", "/usr/include/linux/types.h")
    assert "/usr/include" in entered("python3", "/usr/include/stdio.h")[1]


@pytest.mark.parametrize("arguments, path, is_bound", [
    ("python3 /usr/include/stdio.h", "/usr/include", True),  # with neighbouring files
    ("python3 --out=/usr/include/new/run", "/usr/include", True),  # a file still to be made
    ("python3 /etc/../usr/include/stdio.h", "/usr/include", True),
    ("python3 /usr/bin/env", "/usr/bin/env", True),  # in a folder of the root: this file alone
    ("/usr/bin/python3 scene.py", "/usr/bin/python3", False),  # the root has it
])
def test_an_argument_under_usr_is_bound(entered, arguments, path, is_bound):
    assert (path in entered(arguments)[1]) == is_bound


@pytest.mark.parametrize("arguments, last", [
    ("/no-such-top/x.csv", "/no-such-top/x.csv"),
    ("--out=/no-such-top/x.csv", "--out=/no-such-top/x.csv"),
    ("--out /no-such-top/a/b", "/no-such-top/a/b"),
    ("--out ''", "--out"),  # `calls` shows no empty word
])
def test_an_argument_that_does_not_exist_is_left_to_the_command(entered, arguments, last):
    assert entered("python3", arguments)[0][-1] == last


def test_each_stage_of_the_set_up_prints_its_duration(machine):
    machine.bare('echo "yade-rcr: set-up 2/3: packages (1 min) …" >&2; sleep 1' + SMALL_ROOT)
    assert re.fullmatch(r"yade-rcr: set-up 1/3: .*\nyade-rcr: set-up 1/3 took \d+ s\n"
                        r"yade-rcr: set-up 2/3: packages \(1 min\) …\n"
                        r"yade-rcr: set-up 2/3 took [1-9]\d* s\n", machine.succeeds("ready"))


def test_inside_it_nothing_is_entered_again(machine):
    """YADE fails without HOME: a directory in the cache takes its place."""
    (machine.cache / "root").mkdir(parents=True)
    way = dict(YADE_RCR_WAY="native")
    code, output, errors = machine.run("ready; enter sh -c 'echo $PYTHONPATH'", **way)
    assert code == 0 and output.startswith(f"{machine.repo}/py:"), errors
    machine.succeeds("ready; enter sh -c 'echo $HOME'", f"{machine.cache}/home\n", **way, HOME="")
    assert (machine.cache / "home").is_dir() and not machine.called("bwrap")


# Packages: an index that names files the mirror does not have

HOLE = ('echo "E: Failed to fetch http://mirror/pool/g/g++_4%3a14.2-1%2bb1_amd64.deb  404  '
        'Not Found [IP: 1]"; exit 100')


@pytest.mark.parametrize("apt_get, complete, words", [
    pytest.param("exit 0", True, [], id="all packages"),
    pytest.param(f"""
for word in "$@"; do case $word in Dir::Etc::Preferences=*) pins=${{word#*=}} ;; esac; done
case "$*" in *install*g++*) grep -q "^Pin: version 4:14.2-1+b1" $pins || {{ {HOLE}; }} ;; esac""",
                 True, ["g++ 4:14.2-1+b1", "404"], id="another version"),
    pytest.param(f'case "$*" in *install*g++*) {HOLE} ;; esac', False,
                 ["this mirror cannot provide"], id="no other version"),
    pytest.param('case "$*" in *install*tqdm*) echo "E: Unable to locate"; exit 100 ;; esac', True,
                 ["python3-tqdm", "progress bars"], id="without an optional package"),
])
def test_required_packages_are_installed_together(machine, apt_get, complete, words):
    """A missing file is named and another version tried; messages name what is lost."""
    (machine.path / "list").write_text("yade\ng++\n? python3-tqdm: progress bars\n")
    machine.command("apt-get", apt_get)
    code, _, errors = machine.run("$setup/install-packages list")
    assert (code == 0) == complete and all(word in errors for word in words), errors
    assert complete or "g++" in last_line(errors)
    assert machine.called("apt-get")[1].endswith("install --no-install-recommends yade g++")


# The build

def build(machine, cmake, yade="2025.2.0"):
    machine.installed(f"{yade}-1")
    machine.command("cmake", cmake)
    return machine.run("ready; build", YADE_RCR_WAY="native")


def test_failed_configurations_and_builds_show_everything_and_are_done_again(machine):
    code, _, errors = build(machine, 'echo "CMake Error: no pybind11"; exit 1')
    assert code != 0 and "no pybind11" in errors
    code, _, errors = build(machine, 'case $1 in --build) echo "[1/2] CXX a.cpp"; echo '
                            '"a.cpp:1: error: x"; exit 1 ;; esac')
    assert code != 0 and "error: x" in errors and "the build failed" in last_line(errors)
    assert any("-DYADE_SOURCE_DIR=" in call for call in machine.called("cmake")[1:])


def test_another_environment_or_a_moved_clone_wipes_the_build(machine):
    """CMake's cache holds absolute paths."""
    assert build(machine, "exit 0")[0] == 0
    for version, folder, kept in (("2025.2.0", "repo", True), ("2026.1.0", "repo", False),
                                  ("2026.1.0", "moved", False)):
        (machine.repo / "build" / "stale").touch()
        machine.repo = machine.repo.rename(machine.path / folder)
        assert build(machine, "exit 0", version)[0] == 0
        assert (machine.repo / "build" / "stale").exists() == kept


def test_a_second_build_waits_for_one_that_has_work(machine):
    """It configures, then compiles. Those without work are silent, also beyond the patience."""
    two_builds = lambda work, until: two_at_once(machine, "ready; build", "cmake", work, until,
                                                 YADE_RCR_WAY="native")
    for work in ("", 'echo "[1/2] CXX a.cpp"'):
        results = two_builds(work, lambda flocks: "flock 9" in flocks)
        assert sum("waiting for another build" in errors for _, errors in results) == 1, results
    nothing = 'echo "ninja: no work to do."'
    assert build(machine, nothing) == (0, "", "")
    impatient = lambda flocks: len(flocks) >= 4 or "flock 9" in flocks  # has waited twice
    assert two_builds(nothing, impatient) == [("", "")] * 2
    assert not (machine.repo / "build" / "working").exists()
