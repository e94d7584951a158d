// What the step programs share: the packing that they read, the step that they are asked for, the JSON that they print.
//
// The packing is a text file of numbers, one body a row (numpy.savetxt). A grain has a radius; a wall has none but an
// outward normal, and its x, y is a point of its face. Mass 0: prescribed motion. Any consistent units, mean diameter 1.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

struct BodyRow {
	double x, y, angle, halfLength, radius, mass, inertia, vx, vy, omega, fx, fy, normalX, normalY;

	bool isGrain() const { return radius > 0; }
};

struct Task {
	std::vector<BodyRow> bodies;
	double               dt = 0, friction = 0, slop = 0; // slop: overlap that is left alone
	int                  iterations = 0, steps = 0;
};

/// One contact point: bodies by row, normal from body 1 to body 2, arms from their centres, impulse, signed gap.
struct ContactRow {
	int    body1, body2;
	double nx, ny, r1x, r1y, r2x, r2y, friction, normalImpulse, tangentImpulse, gap;
};

struct Velocity {
	double x, y, omega;
};

/// What was measured; contacts and velocities are those of the last step.
struct Outcome {
	std::string             library;
	std::vector<double>     seconds;
	std::vector<ContactRow> contacts;
	std::vector<Velocity>   before, after;
};

constexpr double wallHalfLength = 1000, wallThickness = 2;

inline std::vector<BodyRow> readBodies(const char* path)
{
	std::ifstream file(path);
	if (!file) throw std::runtime_error(std::string(path) + ": cannot be read");
	std::vector<BodyRow> bodies;
	constexpr int        columns = sizeof(BodyRow) / sizeof(double);
	double               value[columns];
	for (int k = 0; file >> value[k];)
		if (++k == columns) {
			k = 0;
			bodies.emplace_back();
			std::memcpy(&bodies.back(), value, sizeof value);
		}
	if (bodies.empty() || !file.eof())
		throw std::runtime_error(std::string(path) + ": is no table of " + std::to_string(columns) + " numbers a body");
	return bodies;
}

inline Task readTask(int argc, char** argv)
{
	if (argc != 7) throw std::runtime_error("wanted PACKING DT FRICTION SLOP ITERATIONS STEPS");
	Task task { readBodies(argv[1]), std::atof(argv[2]), std::atof(argv[3]), std::atof(argv[4]), std::atoi(argv[5]), std::atoi(argv[6]) };
	if (!(task.dt > 0) || task.iterations < 1 || task.steps < 1) throw std::runtime_error("wanted DT > 0, ITERATIONS and STEPS of at least 1");
	return task;
}

/// Processor time: the libraries run on one thread, and others may want the processor.
template <class Step> double secondsOf(Step step)
{
	const std::clock_t start = std::clock();
	step();
	return double(std::clock() - start) / CLOCKS_PER_SEC;
}

template <class Row, class Write> void printList(const char* name, const std::vector<Row>& rows, Write write)
{
	std::printf(",\n\"%s\": [", name);
	for (std::size_t k = 0; k < rows.size(); ++k) {
		std::printf(k ? ",\n" : "");
		write(rows[k]);
	}
	std::printf("]");
}

inline void print(const Outcome& outcome)
{
	const auto velocity = [](const Velocity& v) { std::printf("[%.17g, %.17g, %.17g]", v.x, v.y, v.omega); };
	std::printf("{\"library\": \"%s\"", outcome.library.c_str());
	printList("seconds", outcome.seconds, [](double s) { std::printf("%.9g", s); });
	printList("contacts", outcome.contacts, [](const ContactRow& c) {
		std::printf("[%d, %d, %.17g, %.17g, %.17g, %.17g, %.17g, %.17g, %.17g, %.17g, %.17g, %.17g]", c.body1, c.body2, c.nx, c.ny, c.r1x, c.r1y,
		            c.r2x, c.r2y, c.friction, c.normalImpulse, c.tangentImpulse, c.gap);
	});
	printList("before", outcome.before, velocity);
	printList("after", outcome.after, velocity);
	std::printf("}\n");
}

/// Reads the task, calls run(task), prints its outcome; 1 and a line where something is wrong.
template <class Run> int stepProgram(int argc, char** argv, Run run)
{
	try {
		print(run(readTask(argc, argv)));
		return 0;
	} catch (const std::exception& error) {
		std::fprintf(stderr, "%s\n", error.what());
		return 1;
	}
}
