// Checks each solved step and counts steps by their outcome.
#pragma once

#include "dem/yadeHeaders.hpp"
#include "kernel/step/step.hpp"
#include "kernel/watch/jam_detector.hpp"
#include "kernel/watch/step_counts.hpp"

namespace yade {

/// Outcome of a solved step.
struct StepOutcome {
	long   iteration;      // O.iter at its beginning
	double endTime;        // O.time at its end [s]
	int    sweeps, points; // sweeps of all passes; contact points
	double residual;
	bool   missed;         // it did not converge, at a tolerance > 0
	bool   yielded;
	double missedError; // estimated error of a missed step, at most 1; else 0 [-]
};

class StepMonitor {
public:
	rcr::StepCounts  steps;
	rcr::JamDetector jam;
	double           largestError = 0; // largest missedError, not saved

	/// Counts the step. Returns a warning, or an empty text. Throws std::runtime_error if overlaps
	/// grow from step to step while bodies are driven.
	std::string count(const rcr::Step&, const StepOutcome&, rcr::ThreadTeam&);

	template <class Archive> void serialize(Archive& archive, unsigned)
	{
		using boost::serialization::make_nvp;
		archive& make_nvp("steps", steps.steps) & make_nvp("missed", steps.missed)
		        & make_nvp("yielded", steps.yielded);
		archive& make_nvp("intruded", steps.intruded)
		        & make_nvp("warnedIntruded", steps.warnedIntruded);
		archive& make_nvp("deepest", steps.deepest) & make_nvp("warnedYielded", steps.warnedYielded)
		        & make_nvp("warnedDepth", steps.warnedDepth);
		archive& make_nvp("jamNewMaxima", jam.newMaxima) & make_nvp("jamYielded", jam.yielded)
		        & make_nvp("jamDeepest", jam.deepest);
	}
};

/// If a solved velocity is not finite, saves the problem to a file and throws std::runtime_error.
/// Calls Python, so it takes the GIL.
void checkFinite(const rcr::Step&, long iteration);

/// Call it for unconverged steps with large displacements. Throws std::runtime_error if contacts
/// have added more energy than T(v⁻) + T(v_free). These are the kinetic energies before the step and
/// at its end without contacts. Steps with driven bodies are exempt.
void checkEnergy(const rcr::Step&, long iteration);

/// Throws std::runtime_error if a stress would stretch the cell by more than 2 % in the step, or
/// press bodies against each other that cannot move along their normal.
void checkCellStress(const rcr::Step&, long iteration);

/// Mean and largest net force on a free grain or clump over the mean normal force of closed points
/// [-]; inf without contacts.
struct UnbalancedForce {
	double mean, largest;
};
UnbalancedForce unbalancedForceOf(const rcr::Step&);

} // namespace yade
