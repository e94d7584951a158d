# Workflow of scripts/campaign: a biaxial test for each case and seed, then their analysis.
#
# Config: see campaign_runs.py; lists have commas. The working directory gets runs/NAME/ as
# scripts/biaxial.py writes it, with its log, and report/.

import pathlib
import sys

SCRIPTS = pathlib.Path(workflow.basedir).parent
sys.path.insert(0, str(workflow.basedir))
import campaign_runs

campaign_runs.check(config)
CASES = campaign_runs.cases(config)
SEEDS = str(config["seeds"]).split(",")
PAPER = f"--paper {config['paper']}" if "paper" in config else ""


rule report:
    input:
        summaries=[
            "runs/" + campaign_runs.run_name(config, case, seed) + "/summary.json"
            for case in CASES
            for seed in SEEDS
        ],
    output:
        "report/analysis.json",
        "report/report.html",
    params:
        paper=PAPER,
        runs=lambda wildcards, input: [str(pathlib.Path(path).parent) for path in input.summaries],
    log:
        "report/log",
    shell:
        "{SCRIPTS:q}/network.py {params.runs} {params.paper} --out report --overwrite >{log} 2>&1"


# Each case has a rule, since a priority belongs to a rule: the tests of long particles take longest
# and start first. A test ends with Snakemake. The lock keeps a test that outlives
# Snakemake, on another node of a cluster, from sharing its folder.
for case in CASES:
    folder = "runs/" + campaign_runs.run_name(config, case, "{seed}")

    rule:
        name:
            "_".join(["biaxial", *case.values()])
        output:
            folder + "/summary.json",
        params:
            options=campaign_runs.options(config, case),
            folder=folder,
        threads: int(config.get("threads", 1))
        priority: int(1000 * float(case.get("eta", 0)))
        resources:
            mem_mb=2000,
        shell:
            """
            exec {{lock}}>{params.folder}/lock
            flock $lock
            resume=
            [ ! -e {params.folder}/checkpoint.yade.gz ] || resume=--resume
            exec setpriv --pdeathsig KILL {SCRIPTS:q}/yade-rcr -n -x -j {threads} \
                {SCRIPTS:q}/biaxial.py {params.options} --seed {wildcards.seed} \
                --threads {threads} --out {params.folder} $resume >{params.folder}/log 2>&1
            """
