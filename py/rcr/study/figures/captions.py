"""Captions: what each figure plots. The report adds the statement of the paper."""

_CURVES = "Each colour is an elongation η; bands and bars are one standard error."
_XI = "of the contacts with f_n ≤ ξ ⟨f_n⟩, over all contacts, against the cutoff ξ"

CAPTIONS = dict(
    O1="(a) Shear strength sin φ of the wall stresses, averaged over 0.01 of strain, against the "
       "strain. (b) Its mean over the averaged strains against the elongation; dashed: the paper.",
    O2="(a) Directions of the contact normals after the compaction; dashed: isotropic. (b) Contacts "
       "of a grain without rattlers; Z_c counts side-side contacts twice. Maps: packings after the "
       "compaction, coloured by the direction of the long axes.",
    O3="Probability density of the normal forces between grains over their mean: (a) log-linear "
       "with the exponent α_n of the tail inset, (b) log-log with the exponent β_n of the weak "
       "forces inset; crosses: β_n fitted from a tenth of the mean on.",
    O4="The same of the sizes of the tangential forces.",
    O5="Mean friction mobilisation |f_t|/(µ f_n) of the contacts between grains against the "
       "elongation.",
    O6="(a) Mean normal force and (b) lateral stress in five vertical strips of the packing over "
       "the mean; grey: ±10 %. Maps: normal forces of the last network as thickness of segments, "
       "red up to the mean and black above; the diameter of the yellow discs is the friction "
       "mobilisation.",
    O7="Mean friction mobilisation of the contacts with a normal force f_n.",
    O8="Probability density of the friction mobilisation.",
    O9="Last network: grains with a side-side contact, coloured by the direction of their long "
       "axis; normal forces as thickness of segments.",
    O10="Probability density of the reduced branch length ℓ/(R₁ + R₂).",
    O11="Last network: contacts coloured by their type.",
    O12="Correlation of the contact force with the branch length ℓ and the reduced branch length "
        "ℓ_r = ℓ/(R₁ + R₂), against the elongation.",
    O13="Mean contact force, over the mean of all contacts, of the contacts of (a) a reduced branch "
        "length, (b) a branch length.",
    O14="Probability density of the directions of contact normals with f_n ≤ ξ ⟨f_n⟩, and its "
        "Fourier fit.",
    O15=f"Anisotropy a_c of the contact normals {_XI}. {_CURVES}",
    O16="(a) Normal and (b) tangential branch components by direction, with fits; (c), (d) their "
        f"anisotropies {_XI}. {_CURVES}",
    O17="(a) Normal and (b) tangential forces by direction, with fits; (c), (d) their anisotropies "
        f"{_XI}. {_CURVES}",
    O18=f"Share q(ξ)/p of the shear stress {_XI}; markers: half the sum of the five anisotropies.",
)
