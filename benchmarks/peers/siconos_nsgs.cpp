// Solves W, q, µ with the parallel Gauss–Seidel of Siconos 5 (OpenMP, colours by PETSc).
//
//   siconos_nsgs PROBLEM.dat IMPULSES THREADS LIMIT
//
// For growing numbers of iterations it starts from zero impulses, until a run takes LIMIT seconds.
// It prints iterations and wall times as JSON and writes the impulses of each run as doubles. The
// times are those of the iterations alone: Siconos colours the contacts again in each call.
#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include <FrictionContactProblem.h>
#include <FrictionContact_options.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <SolverOptions.h>

extern "C" int PetscInitializeNoArguments(void); // its header requires MPI

namespace {

constexpr int    first = 20, repeats = 2;
constexpr double growth = 1.2;

/// Wall time of this number of iterations [s]; `impulses` are those at their end.
double secondsOf(FrictionContactProblem* problem, int iterations, std::vector<double>& impulses)
{
	std::vector<double> velocities(impulses.size());
	std::fill(impulses.begin(), impulses.end(), 0.);
	SolverOptions* options = solver_options_create(SICONOS_FRICTION_2D_NSGS_GRAPH_PERMUT);
	options->iparam[SICONOS_IPARAM_MAX_ITER]                    = iterations;
	options->iparam[SICONOS_FRICTION_3D_IPARAM_ERROR_EVALUATION]
	        = SICONOS_FRICTION_3D_NSGS_ERROR_EVALUATION_LIGHT;
	options->dparam[SICONOS_DPARAM_TOL] = 1e-300;
	fc2d_driver(problem, impulses.data(), velocities.data(), options);
	const double seconds = options->dparam[SICONOS_DPARAM_TIME_IN_LOOP];
	solver_options_delete(options);
	return seconds;
}

void run(const char* problemPath, const char* impulsesPath, int threads, double limit)
{
	FrictionContactProblem* problem = frictionContact_new_from_filename(problemPath);
	std::FILE*              file    = std::fopen(impulsesPath, "wb");
	if (!problem || !file) throw std::runtime_error(std::string("cannot open ") + problemPath);
	PetscInitializeNoArguments();
	omp_set_num_threads(threads);
	std::vector<double> impulses(2 * std::size_t(problem->numberOfContacts));
	std::string         counts, times;
	double              least = 0;
	for (double count = first; least < limit; count *= growth) {
		least = secondsOf(problem, int(count), impulses);
		for (int k = 1; k < repeats; ++k)
			least = std::min(least, secondsOf(problem, int(count), impulses));
		const char* separator = counts.empty() ? "" : ", ";
		counts += separator + std::to_string(int(count));
		times += separator + std::to_string(least);
		std::fwrite(impulses.data(), sizeof(double), impulses.size(), file);
	}
	std::fclose(file);
	std::printf("{\"iterations\": [%s], \"seconds\": [%s]}\n", counts.c_str(), times.c_str());
}

} // namespace

int main(int argc, char** argv)
{
	try {
		if (argc != 5) throw std::runtime_error("expected PROBLEM.dat IMPULSES THREADS LIMIT");
		run(argv[1], argv[2], std::atoi(argv[3]), std::atof(argv[4]));
		return 0;
	} catch (const std::exception& error) {
		std::fprintf(stderr, "siconos_nsgs: %s\n", error.what());
		return 1;
	}
}
