"""Networks from known distributions."""

import numpy as np
from rcr.network import Network

TAU = 2 * np.pi


def polygon_areas(corners):
    """Areas (n,) of n polygons with corners (n, k, 2) by the shoelace formula."""
    x, y = np.moveaxis(corners, -1, 0)
    return 0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)


def particles(count):
    return dict(id=np.arange(count), position=np.zeros((count, 2)), angle=np.zeros(count),
                R=np.ones(count), cap_radius=np.ones(count), half_length=np.zeros(count),
                mass=np.ones(count), velocity=np.zeros((count, 3)))


def network(theta, branch, force, friction=0.5, grains=2, **columns):
    """Contacts at angles θ with (n, t) components of branch and force."""
    n = np.column_stack([np.cos(theta), np.sin(theta)])
    t = np.column_stack([-n[:, 1], n[:, 0]])
    count = len(theta)
    contacts = dict(
        body1=np.zeros(count, int), body2=np.ones(count, int), type=np.zeros(count, int), normal=n,
        branch=branch[:, :1] * n + branch[:, 1:] * t, force=force[:, :1] * n + force[:, 1:] * t,
        position=np.zeros((count, 2)), points=np.ones(count, int))
    return Network(particles(grains), contacts | columns, dict(volume=10.0, friction=friction))


def directions(rng, count, a_c, axis):
    """Angles of normals drawn from P(θ) ∝ 1 + a_c cos 2(θ − axis), by rejection; (count,) [rad]."""
    theta = rng.uniform(0, TAU, 4 * count)
    density = 1 + a_c * np.cos(2 * (theta - axis))
    return theta[rng.uniform(0, 1 + abs(a_c), len(theta)) < density][:count]


def anisotropic(count, a_c, a_ln, a_lt, a_fn, a_ft, seed=0, axis=np.pi / 2):
    """Contacts of P(θ) ∝ 1 + a_c cos 2(θ − θσ), with branches and forces of the paper's form."""
    theta = directions(np.random.default_rng(seed), count, a_c, axis)
    cos, sin = np.cos(2 * (theta - axis)), np.sin(2 * (theta - axis))
    branch = np.column_stack([1 + a_ln * cos, a_lt * sin])
    return network(theta, branch, np.column_stack([1 + a_fn * cos, a_ft * sin]))


def random_network(count=500, seed=3, **columns):
    rng = np.random.default_rng(seed)
    force = np.column_stack([rng.exponential(1, count), np.zeros(count)])
    force[:, 1] = 0.5 * force[:, 0] * rng.uniform(-1, 1, count)
    return network(rng.uniform(0, TAU, count),
                   np.column_stack([rng.uniform(0.5, 2, count), rng.normal(0, 0.3, count)]), force,
                   **columns)


def packing(eta, seed=0, particles_=200, contacts=2000, strain=0.4, friction=0.5, a_c=0.2, a_fn=0.3,
            a_ft=0.1, axis=np.pi / 2, attributes=None):
    """Grains at random places with P(θ), ⟨f_n⟩(θ), ⟨f_t⟩(θ) of the paper's form, |f_t| ≤ µ f_n, and
    exponential forces; tangents are n turned by −90°, as in the paper.
    """
    rng = np.random.default_rng(seed)
    theta = directions(rng, contacts, a_c, axis)
    cos, sin = np.cos(2 * (theta - axis)), np.sin(2 * (theta - axis))
    fn = rng.exponential(1, contacts) * (1 + a_fn * cos)
    along = rng.uniform(-0.3, 0.3, contacts) + a_ft * sin / (1 + a_fn * cos)
    along = np.clip(along, -friction, friction)
    branch = np.column_stack([1 - eta * rng.uniform(0, 0.5, contacts),
                              eta * rng.uniform(-0.2, 0.2, contacts)]) * 2
    one = rng.integers(0, particles_, contacts)
    grains = particles(particles_) | dict(
        position=rng.uniform(0, 30, (particles_, 2)), angle=rng.uniform(0, np.pi, particles_),
        cap_radius=np.full(particles_, 1 - eta), half_length=np.full(particles_, eta))
    columns = dict(body1=one, body2=(one + rng.integers(1, particles_, contacts)) % particles_,
                   position=grains["position"][one],
                   type=rng.integers(0, 3, contacts) if eta else np.zeros(contacts, int))
    force = np.column_stack([fn, -fn * along])
    made = network(theta, branch, force, friction, particles_, **columns)
    return Network(grains, made.contacts, dict(volume=900.0, friction=friction, eta=eta,
                                               strain=strain, seed=seed, **attributes or {}))


def write_run(folder, eta, seed=0, strains=(0.1, 0.2, 0.3, 0.4), **options):
    folder.mkdir(parents=True)
    for k, strain in enumerate(strains):
        moment = packing(eta, seed=100 * seed + k, strain=strain, **options)
        moment.save(folder / f"network-{strain:.4f}.h5")
    at_rest = options | dict(strain=0.0, friction=0.0, a_c=0, a_fn=0, a_ft=0)
    packing(eta, 100 * seed + 99, **at_rest).save(folder / "isotropic.h5")
    ratios = [0.3 + 0.3 * eta + 0.01 * (-1) ** k for k in range(101)]
    rows = [f"{strain},{1 - ratio},{1 + ratio}"
            for strain, ratio in zip(np.linspace(0, strains[-1], 101), ratios)]
    (folder / "history.csv").write_text("\n".join(["strain,stress_x,stress_y", *rows]) + "\n")
    return folder
