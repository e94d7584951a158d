#include "dem/loads/WallStress.hpp"

#include "dem/errors/messages.hpp"

namespace yade {

static const Wall* wallOf(const Scene& scene, int id)
{
	return scene.bodies->exists(id)
	        ? dynamic_cast<const Wall*>((*scene.bodies)[id]->shape.get())
	        : nullptr;
}

std::string WallStress::attributeError(const Scene& in) const
{
	for (const auto& [name, id] :
	        { std::pair("wall", wall), std::pair("start", start), std::pair("end", end) })
		if (!wallOf(in, id))
			return std::string("WallStress.") + name + " = " + std::to_string(id)
			        + " is not the id of a body with the shape Wall; "
			          "give the ids of the pressed wall and of the two that bound it.";
	const int pressed = wallOf(in, wall)->axis, one = wallOf(in, start)->axis,
	          two = wallOf(in, end)->axis;
	if (start == end)
		return "WallStress.start and WallStress.end are both " + std::to_string(start)
		        + ", so that the pressed length is 0; give the ids of the two walls that bound it.";
	if (one != two || one == pressed)
		return "WallStress: the walls `start` and `end` must be parallel to each other and not to "
		       "`wall`.";
	if ((*in.bodies)[wall]->state->blockedDOFs & State::axisDOF(pressed))
		return "WallStress.wall = " + std::to_string(wall) + " is held along " + "xyz"[pressed]
		        + ", so that no stress moves it; take rcr.mobile_wall, or set WallStress.dead.";
	if (math::isfinite(stress)) return {};
	return "WallStress.stress = " + errors::text(stress)
	        + "; expected a finite stress [Pa]; a negative one pushes towards smaller coordinates.";
}

void WallStress::action()
{
	const std::string message = attributeError(*scene);
	if (!message.empty()) throw std::invalid_argument(message);
	const int  along = wallOf(*scene, start)->axis;
	const auto place  = [&](int id) { return (*scene->bodies)[id]->state->pos[along]; };
	Vector3r force                    = Vector3r::Zero();
	force[wallOf(*scene, wall)->axis] = stress * math::abs(place(end) - place(start));
	scene->forces.addForce(wall, force);
}

} // namespace yade
