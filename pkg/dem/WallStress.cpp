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
	const auto pressed = wallOf(wall, "wall"), one = wallOf(start, "start"), two = wallOf(end, "end");
	if (one.second != two.second || one.second == pressed.second)
		throw std::invalid_argument("WallStress: the walls `start` and `end` must be parallel to each other and not to `wall`.");
	Vector3r force        = Vector3r::Zero();
	force[pressed.second] = stress * math::abs(two.first.pos[two.second] - one.first.pos[one.second]);
	scene->forces.addForce(wall, force);
}

} // namespace yade
