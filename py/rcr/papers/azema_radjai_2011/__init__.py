"""Azéma and Radjaï 2011, whose biaxial test and figures the study repeats.

Values and trends come from the text, since the data of the figures are not available. Criteria
stand in `forces` (O1 to O9) and `networks` (O10 to O18).
"""

from rcr.study.paper import Paper

STATEMENTS = dict(
    O1="sin φ = (σ₁ − σ₂)/(σ₁ + σ₂) saturates at the critical state, linear in η from about 0.30 "
       "(η = 0) to about 0.51 (η = 0.7)",
    O2="after compaction the packing is isotropic: P(θ) = 1/π",
    O3="P(f_n) ∝ exp(−α_n f_n/⟨f_n⟩) above the mean, (f_n/⟨f_n⟩)^β_n below; α_n falls with η, β_n "
       "from 0.1 to −0.4, weak contacts 60 % to 70 %",
    O4="P(f_t) of the same form; α_t and β_t fall with η and saturate beyond η = 0.4",
    O5="mean friction mobilisation I_M = ⟨|f_t|/(µ f_n)⟩ from 0.4 (η = 0) to 0.6 (η = 0.7)",
    O6="map of forces and friction mobilisation: mobilised contacts belong mostly to the weak "
       "network",
    O7="mean I_m of a bin of f_n falls with f_n and rises with η at every force",
    O8="P(I_m): discs a nearly linear decrease, then uniform, then a bin close to I_m = 1",
    O9="map of the long axes of particles with a side-side contact: nematic chains at η = 0.7",
    O10="P(ℓ_r) has modes at 1 − η (grows with η), near 1 − η/2 (shrinks) and near 1",
    O11="map of contact types: layers of side-side contacts, whose share grows with η",
    O12="correlations C(f, ℓ_r) and C(f, ℓ) fall with η, positive for η ≤ 0.3, negative above, "
        "down to −0.22",
    O13="mean force of a bin of ℓ_r near the mean, but above it for side-side and well below "
        "for aligned cap-cap; with ℓ it rises for η ≤ 0.3, falls above",
    O14="P(θ, ξ) at η = 0.5: the same axis for every ξ, that of σ₁, and an anisotropy that grows "
        "with ξ",
    O15="a_c(ξ): discs negative with its extremum at ξ ≈ 1, then positive; η > 0 positive for "
        "every ξ, about 0.3 at ξ = 1 for long particles",
    O16="a_ln > 0 for η ≤ 0.1, else negative with a peak for ξ in [1, 2]; a_lt < 0 and monotonic; "
        "|a_lt| > |a_ln|, both ≪ a_c",
    O17="a_fn: discs positive; η > 0 negative for ξ < 1, extremum at ξ = 1, positive beyond ξ ≈ "
        "2; a_ft rises with ξ and η",
    O18="q(ξ)/p: discs 0 for ξ < 1; below 0.1 at ξ = 1 for every η; half-sum of the anisotropies "
        "an excellent fit at every ξ",
)

PAPER = Paper(
    about="The results are set against Azéma and Radjaï, "
          "<a href='https://arxiv.org/abs/1108.3164'><i>Force chains and contact network topology "
          "in packings of elongated particles</i></a>, who sheared packings of 13 000 grains.",
    statements=STATEMENTS,
    maps=dict(
        O2=(0, 0.4, 0.7),
        O6=(0.2, 0.7),  # 0.1 in the paper's text, 0.2 in its caption
        O9=(0.7,), O11=(0.7,)),
    first=[
        ("O1", "Shear strength against elongation; dashed: the paper."),
        ("map", "Contact forces at η = {:g}: black above the mean, red up to it; the thicker the "
         "larger."),
        ("O3", "How often a normal force of a given size occurs; the mean is 1."),
        ("O15", "Anisotropy of the contacts with forces up to ξ times the mean; positive: more "
         "contacts along the largest stress σ₁.")],
    polar_eta=0.5, strength=lambda eta: 0.3 + 0.3 * eta,
    strength_label=r"paper: $0.30 + 0.30\,\eta$")

from rcr.papers.azema_radjai_2011 import forces, networks  # noqa: E402, F401: they add claims
