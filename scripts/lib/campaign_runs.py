"""Names and options of the biaxial tests of a campaign, from the configuration of Snakemake.

A case is what the tests of a campaign differ in beside their seed: {option of biaxial.py: text}.
"""

import itertools

# options of scripts/biaxial.py that all tests share
OPTIONAL = "networks", "iterations", "time_step", "friction", "shape", "size_span"
LISTS = "etas", "sides", "rolling_friction"  # with commas; etas or sides, and rolling_friction
REQUIRED = "particles", "strain", "seeds"


def check(config):
    """Raise a ValueError for a configuration with unknown names, or without one of `REQUIRED`."""
    unknown = set(config) - {*REQUIRED, *OPTIONAL, *LISTS, "threads", "paper"}
    missing = set(REQUIRED) - set(config)
    for given, names in (("unknown", unknown), ("missing", missing)):
        if names:
            raise ValueError(f"--config: {given} {', '.join(sorted(names))}; expected "
                             f"{', '.join(REQUIRED)}, etas or sides, and optionally threads, paper, "
                             f"rolling_friction, {', '.join(OPTIONAL)}")
    if ("etas" in config) == ("sides" in config):
        raise ValueError("--config: expected either etas or sides")


def cases(config):
    """Return the cases of a campaign."""
    names = dict(etas="eta", sides="sides", rolling_friction="rolling-friction")
    given = [[(names[name], value) for value in str(config[name]).split(",")]
             for name in LISTS if name in config]
    return [dict(case) for case in itertools.product(*given)]


def label(case):
    """Return the name of a case for messages."""
    words = {"eta": "η = {}", "sides": "{} sides", "rolling-friction": "µ_r = {}"}
    return ", ".join(words[name].format(value) for name, value in case.items())


def _given(config):
    names = [name for name in ("particles", "strain", *OPTIONAL) if name in config]
    return [(name.replace("_", "-"), config[name]) for name in names]


def run_name(config, case, seed):
    """Return the folder of a test; it holds all parameters, so that a checkpoint there fits."""
    pairs = [*_given(config), *case.items(), ("seed", seed)]
    return "-".join(f"{name}-{value}" for name, value in pairs)


def options(config, case):
    """Return the options of scripts/biaxial.py that the tests of a case share."""
    return " ".join(f"--{name} {value}" for name, value in [*case.items(), *_given(config)])
