#include "dem/engine/homoDeform.hpp"

namespace yade {

void suppressHomoDeform(Scene& scene, bool suppress)
{
	const std::string key = "rcr.homoDeform=";
	const auto        tag = std::find_if(scene.tags.begin(), scene.tags.end(),
	               [&](const std::string& t) { return t.compare(0, key.size(), key) == 0; });
	int& present = scene.cell->homoDeform;
	if (suppress && present != 0) {
		if (tag != scene.tags.end()) scene.tags.erase(tag);
		scene.tags.push_back(key + std::to_string(std::exchange(present, 0)));
	} else if (!suppress && tag != scene.tags.end()) {
		if (present == 0) present = std::atoi(tag->c_str() + key.size()); // else a script has set it
		scene.tags.erase(tag);
	}
}

} // namespace yade
