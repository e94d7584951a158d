// Classes of pkg/dem, with their factories, serialization and Python classes. A class may also
// register itself by YADE_PLUGIN in its own file. This is half of the plugin's code, and runs once.
// The compiler emits the virtual functions of a class beside its first virtual function, here the
// destructor.
#include "dem/contacts/CdPhys.hpp"
#include "dem/contacts/Law2_RcrGeom_FrictPhys_CundallStrack.hpp"
#include "dem/engine/ContactDynamics.hpp"
#include "dem/loads/CellStress.hpp"
#include "dem/loads/WallStress.hpp"

namespace yade {

// clang-format off
#define RCR_CLASSES                                                                                \
	(Rcr)(Bo1_Rcr_Aabb)(Bo1_Disc_Aabb)(RoundedPolygon)(Bo1_RoundedPolygon_Aabb)                    \
	(RcrGeom)(Ig2_Planar_RcrGeom)                                                                  \
	(Ig2_Rcr_Rcr_RcrGeom)(Ig2_Wall_Rcr_RcrGeom)(Ig2_Box_Rcr_RcrGeom)(Ig2_Facet_Rcr_RcrGeom)        \
	(Ig2_Sphere_Rcr_RcrGeom)(Ig2_Sphere_Sphere_RcrGeom)                                            \
	(Ig2_Wall_Sphere_RcrGeom)(Ig2_Box_Sphere_RcrGeom)(Ig2_Facet_Sphere_RcrGeom)                    \
	(Ig2_RoundedPolygon_RoundedPolygon_RcrGeom)(Ig2_Rcr_RoundedPolygon_RcrGeom)                    \
	(Ig2_Sphere_RoundedPolygon_RcrGeom)(Ig2_Wall_RoundedPolygon_RcrGeom)                           \
	(Ig2_Box_RoundedPolygon_RcrGeom)(Ig2_Facet_RoundedPolygon_RcrGeom)                             \
	(CdPhys)(Ip2_FrictMat_FrictMat_CdPhys)(Law2_RcrGeom_CdPhys_SignoriniCoulomb)                   \
	(RcrFrictPhys)(Law2_RcrGeom_FrictPhys_CundallStrack)
// clang-format on
#define RCR_DESTRUCTOR(r, data, Name) Name::~Name() = default;

BOOST_PP_SEQ_FOR_EACH(RCR_DESTRUCTOR, , RCR_CLASSES)
YADE_PLUGIN(RCR_CLASSES(ContactDynamics)(WallStress)(CellStress));

} // namespace yade
