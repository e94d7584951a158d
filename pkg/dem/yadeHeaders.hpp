// YADE's headers for the whole plugin; no other file includes one.
//
// REGISTER_FACTORABLE makes a factory of each class, and with it the class's virtual functions. The
// running YADE has those of its own classes, so the macro is empty for YADE's headers.
#pragma once

#include <lib/factory/ClassFactory.hpp>
#pragma push_macro("REGISTER_FACTORABLE")
#undef REGISTER_FACTORABLE
#define REGISTER_FACTORABLE(name)

#include <boost/python.hpp>

#include <core/Aabb.hpp>
#include <core/Body.hpp>
#include <core/Bound.hpp>
#include <core/Cell.hpp>
#include <core/Clump.hpp>
#include <core/Dispatching.hpp>
#include <core/EnergyTracker.hpp>
#include <core/GlobalEngine.hpp>
#include <core/Interaction.hpp>
#include <core/InteractionContainer.hpp>
#include <core/InteractionLoop.hpp>
#include <core/Omega.hpp>
#include <core/PartialEngine.hpp>
#include <core/Scene.hpp>
#include <core/Shape.hpp>
#include <core/State.hpp>
#include <core/ThreadRunner.hpp>
#include <core/TimeStepper.hpp>
#include <lib/base/Logging.hpp>
#include <lib/pyutil/gil.hpp>
#include <pkg/common/Bo1_Aabb.hpp>
#include <pkg/common/BoundaryController.hpp>
#include <pkg/common/Box.hpp>
#include <pkg/common/Collider.hpp>
#include <pkg/common/ElastMat.hpp>
#include <pkg/common/Facet.hpp>
#include <pkg/common/FieldApplier.hpp>
#include <pkg/common/ForceResetter.hpp>
#include <pkg/common/InsertionSortCollider.hpp>
#include <pkg/common/KinematicEngines.hpp>
#include <pkg/common/MatchMaker.hpp>
#include <pkg/common/PeriodicEngines.hpp>
#include <pkg/common/Sphere.hpp>
#include <pkg/common/StepDisplacer.hpp>
#include <pkg/common/Wall.hpp>
#include <pkg/dem/DemXDofGeom.hpp>
#include <pkg/dem/ForceTorqueRecorder.hpp>
#include <pkg/dem/FrictPhys.hpp>
#include <pkg/dem/GlobalStiffnessTimeStepper.hpp>
#include <pkg/dem/NewtonIntegrator.hpp>
#include <pkg/dem/PeriIsoCompressor.hpp>
#ifdef RCR_OPENGL
#include <pkg/common/GLDrawFunctors.hpp>
#include <pkg/common/OpenGLRenderer.hpp>
#endif

#pragma pop_macro("REGISTER_FACTORABLE")
