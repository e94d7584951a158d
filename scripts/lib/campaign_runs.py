"""Names and options of the biaxial tests of a campaign, from the configuration of Snakemake."""

OPTIONAL = "networks", "iterations", "time_step", "friction"  # of scripts/biaxial.py
REQUIRED = "particles", "strain", "etas", "seeds"


def check(config):
    """Raise a ValueError for a configuration with unknown names, or without one of `REQUIRED`."""
    unknown = set(config) - {*REQUIRED, *OPTIONAL, "threads"}
    missing = set(REQUIRED) - set(config)
    for given, names in (("unknown", unknown), ("missing", missing)):
        if names:
            raise ValueError(f"--config: {given} {', '.join(sorted(names))}; expected "
                             f"{', '.join(REQUIRED)} and optionally threads, {', '.join(OPTIONAL)}")


def _given(config):
    names = [name for name in ("particles", "strain", *OPTIONAL) if name in config]
    return [(name.replace("_", "-"), config[name]) for name in names]


def run_name(config, eta, seed):
    """Return the folder of a test; it holds all parameters, so that a checkpoint there fits."""
    return "-".join([*(f"{name}-{value}" for name, value in _given(config)),
                     f"eta-{eta}-seed-{seed}"])


def options(config):
    """Return the options of scripts/biaxial.py that all tests share."""
    return " ".join(f"--{name} {value}" for name, value in _given(config))
