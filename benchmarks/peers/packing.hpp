// Shared parts of the step programs: reads the packing and the arguments, prints JSON.
//
// The packing is a text file of numbers, one body a row (numpy.savetxt). A grain has a radius > 0.
// A wall has radius 0 and an outward normal; its x, y is a point of its face. Mass 0 is prescribed
// motion. Units are consistent, with the mean diameter as length.
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
	double               dt = 0, friction = 0, slop = 0; // slop: overlap that is not corrected
	int                  iterations = 0, steps = 0;
};

/// Contact point: rows of the bodies, normal from body 1 to body 2, arms from the centres, impulse, gap.
struct ContactRow {
	int    body1, body2;
	double nx, ny, r1x, r1y, r2x, r2y, friction, normalImpulse, tangentImpulse, gap;
};

struct Velocity {
	double x, y, omega;
};

/// Results; contacts and velocities are of the last step.
struct Outcome {
	std::string             library;
	std::vector<double>     seconds;
	std::vector<ContactRow> contacts;
	std::vector<Velocity>   before, after;
	bool                    complete = true; // impulses are those of the whole step
};

constexpr double wallHalfLength = 1000, wallThickness = 2;

inline std::vector<BodyRow> readBodies(const char* path)
{
	std::ifstream file(path);
	if (!file) throw std::runtime_error(std::string(path) + ": cannot be read; give a packing file");
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
		throw std::runtime_error(std::string(path) + ": expected " + std::to_string(columns) + " numbers a body");
	return bodies;
}

inline Task readTask(int argc, char** argv)
{
	if (argc != 7) throw std::runtime_error("expected PACKING DT FRICTION SLOP ITERATIONS STEPS");
	Task task { readBodies(argv[1]), std::atof(argv[2]), std::atof(argv[3]), std::atof(argv[4]), std::atoi(argv[5]), std::atoi(argv[6]) };
	if (!(task.dt > 0) || task.iterations < 1 || task.steps < 1) throw std::runtime_error("expected DT > 0, ITERATIONS >= 1, STEPS >= 1");
	return task;
}

/// Processor time of a step [s]; the libraries run on one thread.
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
	std::printf("{\"library\": \"%s\", \"complete\": %s", outcome.library.c_str(),
	        outcome.complete ? "true" : "false");
	printList("seconds", outcome.seconds, [](double s) { std::printf("%.9g", s); });
	printList("contacts", outcome.contacts, [](const ContactRow& c) {
		std::printf("[%d, %d, %.17g, %.17g, %.17g, %.17g, %.17g, %.17g, %.17g, %.17g, %.17g, %.17g]", c.body1, c.body2, c.nx, c.ny, c.r1x, c.r1y,
		            c.r2x, c.r2y, c.friction, c.normalImpulse, c.tangentImpulse, c.gap);
	});
	printList("before", outcome.before, velocity);
	printList("after", outcome.after, velocity);
	std::printf("}\n");
}

/// Reads the task, runs it and prints the outcome; on an error prints a line and returns 1.
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
