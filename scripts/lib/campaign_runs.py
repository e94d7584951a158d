"""Names and options of the biaxial tests of a campaign, from the configuration of Snakemake."""

OPTIONAL = "iterations", "time_step", "friction"  # options of scripts/biaxial.py that may be absent


def run_name(config, eta, seed):
    """Return the folder of a test; it holds all parameters, so that a checkpoint there fits."""
    parts = [f"particles-{config['particles']}-strain-{config['strain']}"]
    parts += [f"{name.replace('_', '-')}-{config[name]}" for name in OPTIONAL if name in config]
    return "-".join([*parts, f"eta-{eta}-seed-{seed}"])


def options(config):
    """Return the options of scripts/biaxial.py that all tests share."""
    words = [f"--{name} {config[name]}" for name in ("particles", "strain", "networks")]
    words += [f"--{name.replace('_', '-')} {config[name]}" for name in OPTIONAL if name in config]
    return " ".join(words)
