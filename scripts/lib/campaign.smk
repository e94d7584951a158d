# Workflow of scripts/campaign: one biaxial test a job, over elongations and seeds, then the analysis of all.
#
# Config: particles, strain, etas and seeds (with commas), threads and networks of a test, quasi_static 0 or 1. Everything is
# made in the working directory: runs/NAME/ as scripts/biaxial.py writes it, with its log, and report/. A run's name holds all of its parameters, so that a
# checkpoint found there is its own.

import pathlib
import sys

SCRIPTS = pathlib.Path(workflow.basedir).parent
config.setdefault("networks", 10)
ETAS = str(config["etas"]).split(",")
SEEDS = str(config["seeds"]).split(",")
QUASI_STATIC = bool(int(config.get("quasi_static", 0)))
NAME = f"particles-{config['particles']}-strain-{config['strain']}-{'quasi-static-' * QUASI_STATIC}eta-{{eta}}-seed-{{seed}}"


rule report:
    input:
        summaries=expand(f"runs/{NAME}/summary.json", eta=ETAS, seed=SEEDS),
    output:
        "report/analysis.json",
        "report/report.html",
    params:
        runs=lambda wildcards, input: [str(pathlib.Path(path).parent) for path in input.summaries],
    log:
        "report/log",
    shell:
        "{SCRIPTS}/network.py {params.runs} --out report --overwrite >{log} 2>&1"


# A rule for each elongation, since a priority is one of a rule: the longest tests, those of long particles, start first.
# A test dies with Snakemake; the lock is for one that does not, on another machine of a cluster: its files are not touched before it ends.
for eta in ETAS:

    rule:
        name:
            f"biaxial_{eta}"
        output:
            f"runs/{NAME.replace('{eta}', eta)}/summary.json",
        params:
            eta=eta,
            folder=f"runs/{NAME.replace('{eta}', eta)}",
            rate="--quasi-static" if QUASI_STATIC else "",
        threads: int(config.get("threads", 1))
        priority: int(1000 * float(eta))
        resources:
            mem_mb=2000,
        shell:
            """
            exec {{lock}}>{params.folder}/lock
            flock $lock
            resume=
            [ ! -e {params.folder}/checkpoint.yade.gz ] || resume=--resume
            exec setpriv --pdeathsig KILL {SCRIPTS}/yade-rcr -n -x -j {threads} {SCRIPTS}/biaxial.py \
                --eta {params.eta} --seed {wildcards.seed} --particles {config[particles]} --strain {config[strain]} \
                --networks {config[networks]} --threads {threads} {params.rate} --out {params.folder} $resume \
                >{params.folder}/log 2>&1
            """
