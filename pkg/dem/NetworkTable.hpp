// The force-bearing contacts and the particles of the present scene as rows of numbers, for rcr.contact_network.
//
// A step moves the bodies after its forces, so positions are taken back by dt v: to where the forces belong.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace yade {

class Scene;

struct NetworkTable {
	/// One row a pair. Body 1 is a particle; where the other is none (a wall), it is body 2.
	struct Pair {
		std::array<std::int64_t, 4> integers; // body 1, body 2, type, points
		std::array<double, 8>       reals;    // x and y of: normal from 1 to 2, branch, force on 2 [N], point of application [m]
	};
	struct Particle {
		std::int64_t          id;
		std::array<double, 9> reals; // x, y [m], angle [rad], half length, cap radius [m], mass [kg], velocity x, y [m/s], z [1/s]
	};
	std::vector<Pair>     pairs;
	std::vector<Particle> particles;
};

NetworkTable networkTable(const Scene&);

} // namespace yade
