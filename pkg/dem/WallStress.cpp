#include "WallStress.hpp"

#include <core/Scene.hpp>
#include <pkg/common/Wall.hpp>

namespace yade {

YADE_PLUGIN((WallStress));

void WallStress::action()
{
	const auto wallOf = [this](int id, const char* name) {
		const shared_ptr<Body>* body = scene->bodies->exists(id) ? &(*scene->bodies)[id] : nullptr;
		const Wall*             wall = body ? dynamic_cast<const Wall*>((*body)->shape.get()) : nullptr;
		if (!wall)
			throw std::invalid_argument(
			        std::string("WallStress.") + name + " = " + std::to_string(id) + " is not the id of a body with the shape Wall; "
			        "give the ids of the pressed wall and of the two that bound it.");
		return std::pair<const State&, int>(*(*body)->state, wall->axis);
	};
	const auto pressed = wallOf(wall, "wall"), begin = wallOf(from, "from"), end = wallOf(to, "to");
	if (begin.second != end.second || begin.second == pressed.second)
		throw std::invalid_argument("WallStress: the walls `from` and `to` must be parallel to each other and not to `wall`.");
	Vector3r force          = Vector3r::Zero();
	force[pressed.second] = stress * math::abs(end.first.pos[end.second] - begin.first.pos[begin.second]);
	scene->forces.addForce(wall, force);
}

} // namespace yade
