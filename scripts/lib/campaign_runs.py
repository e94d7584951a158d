"""Names and options of the biaxial tests of a campaign, from the configuration of Snakemake."""

OPTIONAL = "iterations", "time_step", "friction"  # options of scripts/biaxial.py that may be absent


def run_name(config, eta, seed):
    """Return the folder of a test; it holds all parameters, so that a checkpoint there fits."""
    parts = [f"particles-{config['particles']}-strain-{config['strain']}"]
    parts += [f"{name.replace('_', '-')}-{config[name]}" for name in OPTIONAL if name in config]
    parts += ["quasi-static"] * is_quasi_static(config)
    return "-".join([*parts, f"eta-{eta}-seed-{seed}"])


def is_quasi_static(config):
    """Return whether the shear has no inertia."""
    return bool(int(config.get("quasi_static", 0)))


def options(config):
    """Return the options of scripts/biaxial.py that all tests share."""
    words = [f"--{name} {config[name]}" for name in ("particles", "strain", "networks")]
    words += [f"--{name.replace('_', '-')} {config[name]}" for name in OPTIONAL if name in config]
    return " ".join([*words, *["--quasi-static"] * is_quasi_static(config)])
