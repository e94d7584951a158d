#include "exact/path_following.hpp"

#include <algorithm>

namespace rcr {

namespace {

	constexpr std::size_t maxUpdates = 20; // between two factorisations; both cost about the same
	constexpr double      minEnergyShare = 0.1; // of unstable contacts, over the largest energy [-]
	constexpr double      edgeTolerance = 1e-13; // distance to the cone that counts as zero [-]

	/// The change of a contact's piece: K += column rowᵀ, in (n, t).
	struct RankOne {
		std::size_t contact;
		LocalVector column, row;
	};

	/// The nearest edge of the present pieces.
	struct Edge {
		double      distance = 0;
		std::size_t contact  = 0;
		Piece       beyond   = {};
		bool        found    = false;
	};

	class Path {
	public:
		explicit Path(ProximalProblem& problem)
		        : problem_(problem)
		        , shift_(problem.size())
		        , velocity_(problem.size())
		        , rate_(problem.size())
		        , direction_(problem.bodies())
		        , response_(problem.bodies())
		{
			updates_.reserve(maxUpdates);
		}

		PathEnd follow(int maxPivots)
		{
			start();
			bool continues = findDirection();
			while (continues && !end_.complete) {
				const Edge edge = nearestEdge();
				advance(edge.distance);
				if (!edge.found) end_.complete = true;
				else
					continues = end_.pivots < maxPivots && pivot(edge);
			}
			setPredictors();
			return end_;
		}

	private:
		/// Sets pieces and shift so that y = 0, p = p_ref is the solution.
		void start()
		{
			for (std::size_t i = 0; i < problem_.size(); ++i) {
				const LocalVector p = problem_.reference[i], u = problem_.referenceVelocity[i];
				const double      limit = problem_.contacts[i].friction * p.n;
				const int         side  = p.t > 0 ? 1 : -1;
				Piece&            piece = problem_.pieces[i];
				shift_[i]               = {};
				if (p.n <= 0) {
					piece = { Piece::apart, 0 };
					if (u.n < 0) shift_[i].n = -u.n;
				} else if (limit <= 0) {
					piece     = { Piece::slide, 0 };
					shift_[i] = { -u.n, 0 };
				} else if (std::abs(p.t) >= limit * (1 - edgeTolerance) && side * u.t < 0) {
					piece     = { Piece::slide, static_cast<std::int8_t>(side) };
					shift_[i] = { -u.n, 0 };
				} else {
					piece     = { Piece::stick, 0 };
					shift_[i] = { -u.n, -u.t };
				}
				velocity_[i] = u + shift_[i];
			}
		}

		/// dy/dt = (I + Ĵᵀ K Ĵ)⁻¹ Ĵᵀ K e with a new factorisation. Returns false if the matrix is
		/// singular.
		bool findDirection()
		{
			updates_.clear();
			if (!problem_.factor()) return false;
			std::fill(direction_.begin(), direction_.end(), BlockVector {});
			for (std::size_t i = 0; i < problem_.size(); ++i) {
				const Piece       piece = problem_.pieces[i];
				const double      k     = problem_.stiffness[i];
				const LocalVector e     = shift_[i];
				if (piece.kind == Piece::apart) continue;
				const double t = piece.kind == Piece::stick
				        ? k * e.t
				        : piece.side * problem_.contacts[i].friction * k * e.n;
				problem_.applyImpulse(i, { k * e.n, t }, direction_);
			}
			problem_.matrix.solve(direction_);
			for (std::size_t i = 0; i < problem_.size(); ++i)
				rate_[i] = problem_.relativeVelocity(i, direction_) - shift_[i];
			return true;
		}

		/// The first contact on the path whose predictor leaves its piece.
		Edge nearestEdge() const
		{
			Edge edge;
			edge.distance       = 1 - t_;
			const auto consider = [&](double value, double slope, std::size_t contact,
			                              Piece beyond) {
				// value ≤ 0 inside the piece, up to rounding
				if (!(slope > 0) || -value >= edge.distance * slope) return;
				edge = { std::max(0.0, -value / slope), contact, beyond, true };
			};
			for (std::size_t i = 0; i < problem_.size(); ++i) {
				const double      k = problem_.stiffness[i], mu = problem_.contacts[i].friction;
				const LocalVector p = problem_.reference[i];
				const double      n = p.n - k * velocity_[i].n, dn = -k * rate_[i].n;
				const double      t = p.t - k * velocity_[i].t, dt = -k * rate_[i].t;
				const Piece       piece = problem_.pieces[i];
				if (piece.kind == Piece::apart) {
					if (dn > 0) consider(n, dn, i, enter(mu, t + dt * std::max(0.0, -n / dn)));
				} else if (piece.kind == Piece::stick) {
					consider(t - mu * n, dt - mu * dn, i, { Piece::slide, 1 });
					consider(-t - mu * n, -dt - mu * dn, i, { Piece::slide, -1 });
				} else {
					consider(-n, -dn, i, { Piece::apart, 0 });
					if (mu > 0)
						consider(mu * n - piece.side * t, mu * dn - piece.side * dt, i,
						        { Piece::stick, 0 });
				}
			}
			return edge;
		}

		/// A contact that closes slides first, because its cone is still a point.
		static Piece enter(double friction, double tangential)
		{
			const int side = friction <= 0 ? 0 : tangential > 0 ? 1 : -1;
			return { Piece::slide, static_cast<std::int8_t>(side) };
		}

		void advance(double distance)
		{
			t_ += distance;
			for (std::size_t i = 0; i < problem_.size(); ++i)
				velocity_[i] = velocity_[i] + distance * rate_[i];
		}

		/// Changes the piece of the contact at an edge and updates the direction. Returns false at
		/// a fold.
		bool pivot(const Edge& edge)
		{
			const RankOne        change = changeOf(edge);
			std::fill(response_.begin(), response_.end(), BlockVector {});
			problem_.applyImpulse(change.contact, change.column, response_);
			applyInverse(response_);
			const LocalVector r     = problem_.relativeVelocity(change.contact, response_);
			const double      delta = 1 + change.row.n * r.n
			        + change.row.t * r.t; // ratio of the determinants
			if (!(delta > 0)) {
				findUnstable();
				return false;
			}
			problem_.pieces[change.contact] = edge.beyond;
			++end_.pivots;
			if (updates_.size() == maxUpdates) return findDirection();
			const LocalVector du     = rate_[change.contact];
			const double      amount = dot(change.row, du) / delta;
			for (std::size_t i = 0; i < problem_.size(); ++i)
				rate_[i] = rate_[i] - amount * problem_.relativeVelocity(i, response_);
			updates_.push_back({ change, delta, response_ });
			return true;
		}

		RankOne changeOf(const Edge& edge) const
		{
			const Piece  from = problem_.pieces[edge.contact], to = edge.beyond;
			const double k  = problem_.stiffness[edge.contact],
			             mu = problem_.contacts[edge.contact].friction;
			if (from.kind == Piece::apart)
				return { edge.contact, { k, k * to.side * mu }, { 1, 0 } };
			if (to.kind == Piece::apart)
				return { edge.contact, { -k, -k * from.side * mu }, { 1, 0 } };
			if (to.kind == Piece::stick) return { edge.contact, { 0, k }, { -from.side * mu, 1 } };
			return { edge.contact, { 0, -k }, { -to.side * mu, 1 } };
		}

		/// b ← A⁻¹ b; A is the factored matrix with its updates.
		void applyInverse(BodyVector& b) const
		{
			problem_.matrix.solve(b);
			for (const Update& update : updates_) {
				const LocalVector u = problem_.relativeVelocity(update.change.contact, b);
				const double      amount = dot(update.change.row, u) / update.delta;
				for (std::size_t i = 0; i < b.size(); ++i)
					for (int j = 0; j < 4; ++j)
						b[i].entry[j] -= amount * update.response[i].entry[j];
			}
		}

		/// At a fold, a matrix between the two pieces is singular. y = A⁻¹ x spans its null space:
		/// motion without resistance. Unstable contacts have a share of its energy Σ k |Ĵ y|².
		void findUnstable()
		{
			std::vector<double> energy(problem_.size(), 0);
			for (std::size_t i = 0; i < problem_.size(); ++i) {
				if (problem_.pieces[i].kind == Piece::apart) continue;
				const LocalVector u = problem_.relativeVelocity(i, response_);
				energy[i]           = problem_.stiffness[i] * square(u);
			}
			const double least = minEnergyShare * *std::max_element(energy.begin(), energy.end());
			for (std::size_t i = 0; i < problem_.size(); ++i)
				if (energy[i] >= least && energy[i] > 0) end_.unstable.push_back(i);
		}

		void setPredictors()
		{
			for (std::size_t i = 0; i < problem_.size(); ++i)
				problem_.predictor[i] = problem_.reference[i]
				        - problem_.stiffness[i] * velocity_[i];
		}

		struct Update {
			RankOne    change;
			double     delta;
			BodyVector response; // A⁻¹ x just before the change
		};

		ProximalProblem&         problem_;
		std::vector<LocalVector> shift_;    // e
		std::vector<LocalVector> velocity_; // u + (1 − t) e on the path
		std::vector<LocalVector> rate_;     // its derivative by t
		BodyVector               direction_, response_;
		std::vector<Update>      updates_;
		double                   t_ = 0;
		PathEnd                  end_;
	};

} // namespace

PathEnd followPath(ProximalProblem& problem, int maxPivots)
{
	return Path(problem).follow(maxPivots);
}

} // namespace rcr
