#!/usr/bin/env python3
"""A campaign on SLURM with a cancelled job gives the results of a local campaign.

scripts/lib/check-in-debian runs this script where SLURM, munge and Snakemake are installed. This
machine is the whole cluster; the daemons keep their files in a temporary folder.
"""

import contextlib
import getpass
import json
import os
import pathlib
import secrets
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "scripts"
PARTICLES, STRAIN, SEED = 30, 0.1, 2
ETAS = "0,0.1,0.2,0.3,0.4,0.5,0.6,0.7"
CPUS = 2
PATIENCE = 900  # time limit [s]; a busy machine takes 300

CONF = """\
ClusterName=check
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
KillWait=5
MinJobAge=3600
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory=8000
PartitionName=check Nodes={host} Default=YES
"""


def ask(*command):
    """Output of a command; its errors go to the terminal."""
    return subprocess.run([str(word) for word in command], check=True, stdout=subprocess.PIPE,
                          text=True).stdout.strip()


def wait_for(what, condition, process):
    """The first true value of the condition; fails if the process ends or patience runs out."""
    end = time.monotonic() + PATIENCE
    while not (value := condition()):
        if process.poll() is not None:
            raise SystemExit(f"slurm.py: {process.args[-1]} ended with {process.returncode} before "
                             f"{what}")
        if time.monotonic() > end:
            raise SystemExit(f"slurm.py: no {what} within {PATIENCE} s")
        time.sleep(0.2)
    return value


def free_ports(count):
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.create_server(("127.0.0.1", 0)))
                   for _ in range(count)]
        return [one.getsockname()[1] for one in sockets]


def jobs(columns, *options):
    return [line.split() for line in ask("squeue", "--noheader", f"--format={columns}",
                                         *options).splitlines()]


@contextlib.contextmanager
def cluster(folder):
    """SLURM with this machine as its only node; sets the variable SLURM_CONF for its commands."""
    host, user, key = socket.gethostname().split(".")[0], getpass.getuser(), folder / "munge.key"
    (folder / "slurm.conf").write_text(CONF.format(host=host, ports=free_ports(2), user=user,
                                                   folder=folder, cpus=CPUS))
    (folder / "cgroup.conf").write_text("CgroupPlugin=disabled\n")
    for name in "state", "spool":
        (folder / name).mkdir()
    key.touch(0o600)
    key.write_bytes(secrets.token_bytes(128))
    os.environ["SLURM_CONF"] = str(folder / "slurm.conf")
    with contextlib.ExitStack() as stack:

        def start(name, *options):
            """A daemon that Ctrl-C does not reach; it ends with this script, even by a kill."""
            daemon = subprocess.Popen(["setpriv", "--pdeathsig", "KILL", name, *options],
                                      stdout=sys.stderr, process_group=0)
            stack.callback(daemon.wait)
            stack.callback(daemon.terminate)
            return daemon

        files = [f"--{name}-file={folder}/munge.{name}" for name in ("key", "pid", "log", "seed")]
        munged = start("munged", "--foreground", *files, f"--socket={folder}/munge.socket")
        wait_for("its socket", (folder / "munge.socket").exists, munged)
        slurmctld = start("slurmctld", "-D")
        slurmd = start("slurmd", "-D")
        idle = lambda: subprocess.run(["sinfo", "--noheader", "--format=%T"], capture_output=True,
                                      text=True).stdout.strip() == "idle"
        wait_for("an idle node", idle, slurmd)
        try:
            yield
        finally:
            ask("scancel", f"--user={user}")
            wait_for("end of all jobs", lambda: not jobs("%i"), slurmctld)


def run_of(out, job):
    return next((out / "runs").glob(f"*-eta-{job.removeprefix('biaxial_')}-seed-{SEED}"), None)


def run_on_slurm(out):
    """Run the campaign; cancel the first job with a checkpoint. Returns its number and name."""
    config = f"particles={PARTICLES} strain={STRAIN} etas={ETAS} seeds={SEED} threads=1".split()
    options = ["--snakefile", SCRIPTS / "lib/campaign.smk", "--directory", out, "--profile",
               SCRIPTS / "lib/slurm", "--config", *config]

    def with_checkpoint():
        running = ((number, name, run_of(out, name))
                   for number, name in jobs("%i %j", "--states=running"))
        return next(((number, name) for number, name, run in running if run
                     and (run / "checkpoint.yade.gz").exists()), None)

    with subprocess.Popen(["setpriv", "--pdeathsig", "KILL", "snakemake", *map(str, options)],
                          stdout=sys.stderr) as snakemake:
        try:
            number, name = wait_for("a job with a checkpoint", with_checkpoint, snakemake)
            ask("scancel", number)
            if snakemake.wait(PATIENCE):
                raise SystemExit(f"slurm.py: Snakemake ended with {snakemake.returncode}; wanted 0")
        finally:
            snakemake.kill()
    return number, name


def main():
    start = time.monotonic()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    os.environ["PATH"] += ":/usr/sbin"
    with tempfile.TemporaryDirectory(prefix="slurm-") as name:
        folder = pathlib.Path(name)
        folder.chmod(0o755)  # munged requires a socket that all users can reach
        out, local = folder / "slurm", folder / "local"
        with cluster(folder):
            number, victim = run_on_slurm(out)
            states = {number: (name, state)
                      for number, name, state in jobs("%i %j %T", "--states=all")}
            version = ask("sinfo", "--version")
        resubmitted = [other for other, (name, state) in states.items() if name == victim and state
                       == "COMPLETED"]
        if states[number][1] != "CANCELLED" or len(resubmitted) != 1:
            raise SystemExit(f"slurm.py: wanted {victim} cancelled as job {number} and completed "
                             f"once; got {states}")
        if not json.loads((run_of(out, victim) / "run.json").read_text()).get("continued"):
            raise SystemExit(f"slurm.py: {victim} was resubmitted, but did not go on from its "
                             f"checkpoint")
        ask(SCRIPTS / "campaign", "--particles", PARTICLES, "--strain", STRAIN, "--etas", ETAS,
            "--seeds", SEED, "--jobs", CPUS, "--out", local)
        compared = subprocess.run([SCRIPTS / "lib/run", "python3", ROOT / "tests/run_contents.py",
                                   out, local], stdout=subprocess.PIPE, text=True)
        if compared.returncode:
            raise SystemExit(f"slurm.py: the campaign on SLURM and the local one differ: "
                             f"{compared.stdout.strip()}")
    print(f"{version}, Snakemake {ask('snakemake', '--version')}: {len(states)} jobs; {victim} "
          f"cancelled as job {number}, resubmitted as job {resubmitted[0]}, "
          f"gone on from its checkpoint; {compared.stdout.strip()} ({time.monotonic() - start:.0f} "
          f"s)")  # fmt: skip


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        raise SystemExit("slurm.py: stopped") from None
