"""`rcr.Network` on networks of known tensors, without YADE."""

import sys

import h5py
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from rcr.frame import Frame
from rcr.network import Network

from common import refused
from damage import put, replace
from synthetic import anisotropic, network, random_network


def test_estimators_recover_known_anisotropies():
    """The sampling error of a mean of cos² over C contacts is about 1/√C.

    Tangents are n turned by +90°: the work-conjugate of cos 2θ is −sin 2θ, so that a force function
    a_ft sin 2(θ − θσ) on n⊗t adds −a_ft. The estimators are linear up to cross products a_c a, of
    the size 0.1 × 0.2 here.
    """
    found = anisotropic(200_000, 0.2, 0.05, 0.02, 0.15, 0.1).anisotropies()
    assert found == pytest.approx((0.2, 0.05, -0.02, 0.15, -0.1), abs=0.01)


def row_and_column(**columns):
    """f = 3 along x on ℓ = 2, f = 1 along y on ℓ = 4, V = 10: σ = diag(0.6, 0.4), q/p = 0.2."""
    return network(np.array([0, np.pi / 2]), np.array([[2.0, 0], [4, 0]]),
                   np.array([[3.0, 0], [1, 0]]), **columns)


def test_stress_of_a_row_and_a_column():
    """Walls count for the stress only."""
    test, at_wall = row_and_column(), row_and_column(body2=np.array([1, -4]), type=np.array([0, 3]))
    for one in test, at_wall:
        assert one.stress() == pytest.approx(np.diag([0.6, 0.4]), abs=1e-15)
    assert at_wall.fabric() == pytest.approx(np.diag([1.0, 0]), abs=1e-15)
    assert test.sin_phi() == pytest.approx(0.2, abs=1e-14)
    assert abs(test.stress_axes()[:, 0]) == pytest.approx([1, 0], abs=1e-14)


def test_the_stress_sums_over_the_points_at_walls():
    """Moments of the points enter the stress at walls and the stress of grains."""
    moments = np.array([[[0.0, 0], [0, 0]], [[1, 2], [3, 4]]])
    columns = dict(points=np.array([1, 2]), point_moments=moments)
    inner = row_and_column(**columns)
    at_wall = row_and_column(body2=np.array([1, -4]), type=np.array([0, 3]), **columns)
    assert inner.stress() == pytest.approx(np.diag([0.6, 0.4]), abs=1e-15)
    assert at_wall.stress() == pytest.approx(np.diag([0.6, 0.4]) + moments[1] / 10)
    areas = Frame.of(inner).areas()
    for test, signs in ((inner, (1, -1)), (at_wall, (1, 0))):
        bare = row_and_column(**{name: test.contacts[name] for name in ("body2", "type")})
        change = (test.grain_stresses() - bare.grain_stresses()) * areas[:, None, None]
        assert change == pytest.approx(np.multiply.outer(signs, moments[1]))


def test_a_network_without_contacts_has_no_axes():
    test = row_and_column()
    none = {name: column[:0] for name, column in test.contacts.items()}
    empty = Network(test.particles, none, test.attributes)
    for call in empty.stress_axes, empty.stress_angle, empty.sin_phi:
        refused("the network has no contact", call)
    assert (empty.stress() == 0).all()


def of_pairs(*pairs, **columns):
    """Contacts of equal forces between these bodies; negative ids are obstacles."""
    one, two = np.array(pairs).T
    return network(np.zeros(len(one)), np.ones((len(one), 2)), np.ones((len(one), 2)), body1=one,
                   body2=two, type=np.where(two < 0, 3, 0), **columns)


def test_a_network_tells_what_it_holds():
    row = of_pairs((0, 1), (0, 1), (0, -2))
    begin = "<Network: 2 grains, 3 contacts, 2 of them between grains, "
    assert repr(row) == begin + "friction 0.5, volume 10>"
    row.attributes |= dict(strain=np.float64(0.1) * 3, seed=4, volume="large")
    assert repr(row) == begin + "strain 0.3, friction 0.5>"


def test_friction_is_that_of_each_contact():
    """I_m = |f_t|/(µ f_n) for µ = 0.5, 0.25 and none: 0.5, 1, and 0 without a limit."""
    force = np.array([[1, 0.25], [2, -0.5], [1, 0], [1, 0]])
    test = network(np.zeros(4), np.ones((4, 2)), force, friction=9.0)
    change = lambda *friction: Network(
        test.particles, test.contacts | dict(friction=np.array(friction)), test.attributes)
    assert change(0.5, 0.25, 0, 0).friction_mobilization() == pytest.approx([0.5, 1, 0, 0])
    refused("friction is NaN for 1 of 4 contacts between grains; .*: give this column or the "
            "attribute", change(0.5, 0.25, 0, np.nan).friction_mobilization)
    refused(r"contacts/friction\[1\] = -1; expected a coefficient ≥ 0", change, 0, -1.0, 0, 0)
    smooth = network(np.zeros(2), np.ones((2, 2)), np.ones((2, 2)), friction=0)
    refused("friction = 0", smooth.friction_mobilization)


def test_ratios_need_no_volume(tmp_path):
    whole = random_network()
    attributes = {name: value for name, value in whole.attributes.items() if name != "volume"}
    bare = Network(whole.particles, whole.contacts, attributes)
    bare.save(tmp_path / "bare.h5")
    again = Network.load(tmp_path / "bare.h5")
    assert "stress" not in again.attributes
    for test in (bare, again):
        assert test.sin_phi() == pytest.approx(whole.sin_phi())
        assert test.stress_angle() == whole.stress_angle()
        for name in ("fabric", "anisotropies", "grain_stresses"):
            assert np.array_equal(getattr(test, name)(), getattr(whole, name)()), name
        for call in (test.stress, test.principal_stresses):
            refused(r"no volume.*contact_network\(volume=…\)", call)


def test_contacts_of_a_clump_are_counted_together():
    """Grains 0 and 1 are one clump between 2 and 3: a chain between obstacles has Z = 2."""
    test = of_pairs((2, -7), (2, 0), (1, 3), (3, -8), grains=4)
    # 0 and 1 have one contact each; without them the others are rattlers too
    assert test.coordination() == 0
    joined = Network(test.particles | dict(clump=np.array([9, 9, -1, -1])), test.contacts,
                     test.attributes)
    assert joined.coordination() == 2 and list(joined.grain_coordination()) == [2, 2, 2, 2]


def test_hooked_clumps_are_a_network():
    """Clumps 7 and 8 pull: the centre of each is beyond the member of the other."""
    test = of_pairs((0, 1))
    hooked = dict(clump=np.array([7, 8]), position=np.array([[0, 0], [2, 0]]),
                  center=np.array([[3, 0], [-1, 0]]))
    contacts = test.contacts | dict(branch=np.array([[-4.0, 0]]))
    hooks = Network(test.particles | hooked, contacts, test.attributes)
    assert hooks.stress()[0, 0] < 0


def test_force_pdf_is_a_density():
    """∫ pdf df = 1 and ∫ f pdf df = 1; 50 classes over 1e4 have an error of 10 % each."""
    f, pdf = random_network(20_000).force_pdf()
    width = np.gradient(f)
    assert np.sum(pdf * width) == pytest.approx(1, rel=0.02)
    assert np.sum(f * pdf * width) == pytest.approx(1, rel=0.05)


def test_coordination_leaves_rattlers_out():
    """A triangle and a grain on one contact, a rattler: Z = 2; with one side contact 8/3."""
    test = of_pairs((0, 1), (1, 2), (2, 0), (2, 3), grains=4, points=np.array([2, 1, 1, 1]))
    assert test.coordination() == pytest.approx(2)
    assert test.coordination(count_side_contacts_twice=True) == pytest.approx(8 / 3)
    # a rattler on one side contact has one contact too
    on_side = of_pairs((0, 1), (1, 2), (2, 0), (2, 3), grains=4, points=np.array([1, 1, 1, 2]))
    assert on_side.coordination(count_side_contacts_twice=True) == pytest.approx(2)
    alive, kept, total = test.backbone()
    assert list(alive) == [True, True, True, False] and list(kept) == [True, True, True, False]
    assert list(total[alive]) == [2, 2, 2]


def test_file_round_trip(tmp_path):
    """Files without the newer columns have the attribute, single grains, positions, no moments."""
    moments = np.zeros((500, 2, 2))
    moments[3] = [[0.1, 0.2], [0.3, 0.4]]
    test = random_network(points=np.where(np.arange(500) == 3, 2, 1), point_moments=moments)
    path = tmp_path / "network-0.h5"
    test.save(path)
    again = Network.load(path)
    for group in ("particles", "contacts"):
        for name, column in getattr(test, group).items():
            assert np.array_equal(getattr(again, group)[name], column), name
    assert again.attributes["volume"] == 10 and again.attributes["friction"] == 0.5
    assert [p.name for p in tmp_path.iterdir()] == ["network-0.h5"]
    with h5py.File(path, "r+") as file:
        for name in ("contacts/friction", "contacts/point_moments", "particles/clump",
                     "particles/center"):
            del file[name]
    again = Network.load(path)
    assert (again.contacts["friction"] == 0.5).all() and (again.particles["clump"] == -1).all()
    assert not again.contacts["point_moments"].any()
    assert np.array_equal(again.particles["center"], again.particles["position"])
    assert again.coordination() == test.coordination()


@pytest.mark.parametrize("name, change, says", [
    ("contacts/body1", put(3, 77), r"contacts/body1\[3\] = 77; expected the id of a particle"),
    ("contacts/body2", put(2, 77), r"contacts/body2\[2\] = 77; expected the id of a particle, "
     r"or a negative one"),
    ("contacts/body2", put(0, 0), r"contacts/body2\[0\] = 0; expected another body"),
    ("contacts/body1", lambda c: c + 0.5, "expected whole numbers"),
    ("contacts/body2", lambda c: c.astype(np.uint64) - 6,  # −5 if it were signed
     r"contacts/body2\[0\] = 1\.84467e\+19; expected whole numbers of 64 bits"),
    ("contacts/type", put(1, 4), r"contacts/type\[1\] = 4; expected 0 to 3"),
    ("contacts/normal", put((4, 0), 3.0), r"the length of contacts/normal\[4\] = 3.*; expected 1"),
    ("contacts/normal", lambda c: c.astype("S5"), "contacts/normal does not hold numbers, but"),
    ("contacts/force", lambda c: c + 1j, "contacts/force does not hold numbers, but complex ones"),
    ("contacts/force", lambda c: -c, "the mean normal force is -.*; expected > 0"),
    *((f"contacts/{name}", lambda c: -c, "distance of grains along contacts/normal is -.*; "
       "expected > 0: branch and normal point from body 1 to body 2")
      for name in ("branch", "normal and contacts/force")),
    ("contacts/force", put((0, 1), np.inf), "contacts/force holds a number that is not finite"),
    ("contacts/force", lambda c: 1.0, r"contacts/force has shape \(\)"),
    ("contacts/force", lambda c: c[:, :1], r"has shape \(500, 1\); expected \(500, 2\)"),
    ("contacts/force", None, "lacks force"),
    ("particles/id", lambda c: 0 * c, r"particles/id\[0\] = 0; expected ids from 0 to 1e\+08, each"),
    ("particles/id", lambda c: 10**13 + c, r"particles/id\[0\] = 1e\+13; expected ids from 0 to"),
    ("particles/clump", lambda c: 10**13 + 0 * c, r"clump\[0\] = 1e\+13; expected −1, or an id up"),
    ("particles/id", lambda c: c - 1, r"particles/id\[0\] = -1; expected ids from 0"),
    ("particles/R", lambda c: 0 * c, r"particles/R\[0\] = 0; expected > 0"),
    ("particles/R", lambda c: 2 * c, r"particles/R\[0\] = .*; expected half_length \+ cap_radius"),
    ("contacts/points", put(1, 7), r"contacts/points\[1\] = 7; expected 1 or 2"),
    ("contacts/point_moments", put((2, 0, 1), 0.5), r"point_moments\[2, 0, 1\] = 0.5; expected 0 for a "
     "contact of one point"),
    ("contacts/type", put(1, 3), r"contacts/type\[1\] = 3; expected 3 for an obstacle as body "
     r"2, and only there"),
    ("particles/R", lambda c: c[:1], r"particles/R has shape \(1,\); expected \(2,\)"),
    *(("attribute", (name, value), f"{name} = ") for name, value in (
        ("eta", 1.0), ("eta", "long"), ("friction", np.nan), ("volume", -1.0), ("volume", 0),
        ("volume", "big"), ("strain", np.inf), ("time", "later"), ("dt", [1, 2]),
        ("cell", np.zeros((2, 2))), ("cell", [[1.0, 2], [0.1, 0.2]]))),
    *(("attribute", ("cell", value), f"the attribute cell{says}") for value, says in (
        (np.ones(4), r" has shape \(4,\)"), ([[1, 0], [0, np.nan]], r"\[1, 1\] = nan"))),
])
def test_files_without_meaning_are_refused(tmp_path, name, change, says):
    path = tmp_path / "network-0.h5"
    random_network().save(path)
    with h5py.File(path, "r+") as file:
        if name == "attribute":
            file.attrs[change[0]] = change[1]
        for column in name.split(" and ") if name != "attribute" else ():
            replace(column, change)(file) if change else file.pop(column)
    error = refused(says, Network.load, path)
    assert str(path) in error and "\n" not in error


STORABLE = "(?s)the attribute note = .*; expected a number, a text, a list of texts or an array of"


@pytest.mark.parametrize("name, value, says", [
    *(("note", value, STORABLE) for value in (
        None, {}, [None], {"a": 1}, [[1], [1, 2]], ["a", 1], 10**30, "a\0b", np.str_("a"),
        np.datetime64("2020-01-01"), np.zeros(10_000), "a" * 70_000, b"a\0b", "\ud800",
        np.ma.masked_array([1.0, 2], [0, 1]))),
    *((name, 1, "an attribute has the name") for name in ("", "a\0b", 3)),
    ("stress", np.eye(2), "the attribute stress = .*; expected another name; files hold")])
def test_attributes_that_no_file_holds_are_refused(name, value, says):
    test = random_network(10)
    refused(says, Network, test.particles, test.contacts, {name: value})


def test_attributes_return_from_a_file(tmp_path):
    test, path = random_network(10), tmp_path / "network-0.h5"
    given_ = dict(number=3, text="ü", flag=True, row=[1.5, 2], texts=["a", "b"], code=b"x", none=[])
    for again in range(2):
        test = Network(test.particles, test.contacts, given_)
        test.save(path)
        given_ = Network.load(path).attributes
    assert given_["number"] == 3 and given_["text"] == "ü" and list(given_["texts"]) == ["a", "b"]


@given(xi=st.one_of(st.floats(), st.integers(), st.none(), st.text(max_size=2), st.booleans(),
                    st.complex_numbers(), st.lists(st.floats(), max_size=3)))
@example(xi=sys.float_info.max)
def test_cutoffs_are_checked(xi):
    """Numbers ≥ 0 give numbers; anything else is refused."""
    test = random_network(50)
    for function in (test.fabric, test.anisotropies, test.shear_stress_ratio):
        try:
            assert np.isfinite(function(xi)).all()
        except ValueError as error:
            assert "xi" in str(error)


@pytest.mark.parametrize("bins", [0, -1, 1.5, None, 10**9, "many"])
def test_bins_are_checked(bins):
    refused("bins", random_network(50).force_pdf, bins)


def test_observables_need_a_force_between_grains():
    test = random_network(10)
    between = test.between_particles
    test.contacts["force"][between] = 0
    for observable in (test.fabric, test.anisotropies, test.force_pdf):
        refused("the mean normal force between grains is 0; expected > 0", observable)
