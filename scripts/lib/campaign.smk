# Workflow of scripts/campaign: a biaxial test for each elongation and seed, then their analysis.
#
# Config: particles, strain, etas and seeds (with commas), threads of a test; optionally networks,
# iterations, time_step and friction. The working directory gets runs/NAME/ as scripts/biaxial.py
# writes it, with its log, and report/.

import pathlib
import sys

SCRIPTS = pathlib.Path(workflow.basedir).parent
sys.path.insert(0, str(workflow.basedir))
import campaign_runs

campaign_runs.check(config)
ETAS = str(config["etas"]).split(",")
SEEDS = str(config["seeds"]).split(",")
OPTIONS = campaign_runs.options(config)


rule report:
    input:
        summaries=[
            "runs/" + campaign_runs.run_name(config, eta, seed) + "/summary.json"
            for eta in ETAS
            for seed in SEEDS
        ],
    output:
        "report/analysis.json",
        "report/report.html",
    params:
        runs=lambda wildcards, input: [str(pathlib.Path(path).parent) for path in input.summaries],
    log:
        "report/log",
    shell:
        "{SCRIPTS:q}/network.py {params.runs} --out report --overwrite >{log} 2>&1"


# Each elongation has a rule, since a priority belongs to a rule: the tests of long particles take
# longest and start first. A test ends with Snakemake. The lock keeps a test that outlives
# Snakemake, on another node of a cluster, from sharing its folder.
for eta in ETAS:
    folder = "runs/" + campaign_runs.run_name(config, eta, "{seed}")

    rule:
        name:
            f"biaxial_{eta}"
        output:
            folder + "/summary.json",
        params:
            eta=eta,
            folder=folder,
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
            exec setpriv --pdeathsig KILL {SCRIPTS:q}/yade-rcr -n -x -j {threads} \
                {SCRIPTS:q}/biaxial.py --eta {params.eta} --seed {wildcards.seed} {OPTIONS} \
                --threads {threads} --out {params.folder} $resume >{params.folder}/log 2>&1
            """
