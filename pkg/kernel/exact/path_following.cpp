#include "exact/path_following.hpp"

#include <algorithm>

namespace rcr {

namespace {

	constexpr std::size_t maxUpdates = 20; // between two factorisations; both cost about the same
	constexpr double      minEnergyShare = 0.1; // of unstable contacts, over the largest energy [-]
	constexpr double      edgeTolerance = 1e-13; // distance to the cone that counts as zero [-]

	/// The change of a contact's piece: K += column rowᵀ, in (n, t, r).
	struct RankOne {
		std::size_t contact;
		RowValues   column, row;
	};

	constexpr int opens = -1; // no friction row: the contact closes or opens

	/// The nearest edge of the present pieces. One friction row changes there, or all that slide.
	struct Edge {
		double      distance = 0;
		std::size_t contact  = 0;
		Piece       beyond   = {};
		int         row      = opens;
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
				const RowValues p = problem_.reference[i], u = problem_.referenceVelocity[i];
				Piece&          piece = problem_.pieces[i];
				piece = {}, shift_[i] = {};
				if (p.n > 0) {
					piece.closed = true;
					shift_[i].n  = -u.n;
					for (int row : { 0, 1 })
						startRow(row, i);
				} else if (u.n < 0)
					shift_[i].n = -u.n;
				velocity_[i] = u + shift_[i];
			}
		}

		void startRow(int row, std::size_t i)
		{
			const FrictionRow of    = frictionRows[row];
			const double      limit = problem_.contacts[i].friction.*of * problem_.reference[i].n,
			                  p = problem_.reference[i].*of, u = problem_.referenceVelocity[i].*of;
			const int         side  = p > 0 ? 1 : -1;
			if (limit <= 0) return;
			if (std::abs(p) >= limit * (1 - edgeTolerance) && side * u < 0) {
				problem_.pieces[i].slides.*of = side;
			} else {
				problem_.pieces[i].sticks[row] = true;
				shift_[i].*of                  = -u;
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
				const Piece& piece = problem_.pieces[i];
				if (!piece.closed) continue;
				const double    k = problem_.stiffness[i];
				const RowValues mu = problem_.contacts[i].friction, e = shift_[i];
				RowValues       p  = k * e;
				if (!piece.sticks[0]) p.t = piece.slides.t * mu.t * k * e.n;
				if (!piece.sticks[1]) p.r = piece.slides.r * mu.r * k * e.n;
				problem_.applyImpulse(i, p, direction_);
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
			                              const Piece& beyond, int row) {
				// value ≤ 0 inside the piece, up to rounding
				if (!(slope > 0) || -value >= edge.distance * slope) return;
				edge = { std::max(0.0, -value / slope), contact, beyond, row, true };
			};
			for (std::size_t i = 0; i < problem_.size(); ++i) {
				const double    k     = problem_.stiffness[i];
				const RowValues p     = problem_.reference[i] - k * velocity_[i],
				                dp    = -k * rate_[i];
				const Piece&    piece = problem_.pieces[i];
				if (!piece.closed) {
					if (dp.n > 0)
						consider(p.n, dp.n, i,
						        enter(i, p + std::max(0.0, -p.n / dp.n) * dp), opens);
					continue;
				}
				if (!piece.anySticks()) consider(-p.n, -dp.n, i, {}, opens);
				for (int row : { 0, 1 }) {
					const FrictionRow of = frictionRows[row];
					const double      mu = problem_.contacts[i].friction.*of;
					if (mu <= 0) continue;
					if (piece.sticks[row])
						for (int side : { 1, -1 })
							consider(side * p.*of - mu * p.n, side * dp.*of - mu * dp.n, i,
							        withRow(piece, row, side), row);
					else
						consider(mu * p.n - piece.slides.*of * p.*of,
						        mu * dp.n - piece.slides.*of * dp.*of, i,
						        withRow(piece, row, 0), row);
				}
			}
			return edge;
		}

		/// The piece with another state of a friction row; side 0: it sticks.
		static Piece withRow(Piece piece, int row, int side)
		{
			piece.sticks[row]               = side == 0;
			piece.slides.*frictionRows[row] = side;
			return piece;
		}

		/// A contact that closes slides first, because its cone is still a point.
		Piece enter(std::size_t i, const RowValues& predictor) const
		{
			Piece piece;
			piece.closed = true;
			for (const FrictionRow of : frictionRows)
				if (problem_.contacts[i].friction.*of > 0)
					piece.slides.*of = predictor.*of > 0 ? 1 : -1;
			return piece;
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
			const RowValues      r      = problem_.relativeVelocity(change.contact, response_);
			const double         delta  = 1 + change.row.n * r.n + change.row.t * r.t
			        + change.row.r * r.r; // ratio of the determinants
			if (!(delta > 0)) {
				findUnstable();
				return false;
			}
			problem_.pieces[change.contact] = edge.beyond;
			++end_.pivots;
			if (updates_.size() == maxUpdates) return findDirection();
			const double amount = dot(change.row, rate_[change.contact]) / delta;
			for (std::size_t i = 0; i < problem_.size(); ++i)
				rate_[i] = rate_[i] - amount * problem_.relativeVelocity(i, response_);
			updates_.push_back({ change, delta, response_ });
			return true;
		}

		RankOne changeOf(const Edge& edge) const
		{
			const Piece &   from = problem_.pieces[edge.contact], &to = edge.beyond;
			const RowValues mu    = problem_.contacts[edge.contact].friction;
			const double    k     = problem_.stiffness[edge.contact];
			RankOne         change { edge.contact, {}, {} };
			if (edge.row == opens) {
				const Piece& closed = to.closed ? to : from;
				const double sign   = to.closed ? k : -k;
				change.column = sign * RowValues { 1, closed.slides.t * mu.t, closed.slides.r * mu.r };
				change.row.n  = 1;
				return change;
			}
			const FrictionRow of     = frictionRows[edge.row];
			const bool        sticks = to.sticks[edge.row];
			change.column.*of        = sticks ? k : -k;
			change.row.*of           = 1;
			change.row.n             = -((sticks ? from : to).slides.*of * mu.*of);
			return change;
		}

		/// b ← A⁻¹ b; A is the factored matrix with its updates.
		void applyInverse(BodyVector& b) const
		{
			problem_.matrix.solve(b);
			for (const Update& update : updates_) {
				const RowValues u      = problem_.relativeVelocity(update.change.contact, b);
				const double    amount = dot(update.change.row, u) / update.delta;
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
				if (!problem_.pieces[i].closed) continue;
				const RowValues u = problem_.relativeVelocity(i, response_);
				energy[i]         = problem_.stiffness[i] * dot(u, u);
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

		ProximalProblem&       problem_;
		std::vector<RowValues> shift_;    // e
		std::vector<RowValues> velocity_; // u + (1 − t) e on the path
		std::vector<RowValues> rate_;     // its derivative by t
		BodyVector             direction_, response_;
		std::vector<Update>    updates_;
		double                 t_ = 0;
		PathEnd                end_;
	};

} // namespace

PathEnd followPath(ProximalProblem& problem, int maxPivots)
{
	return Path(problem).follow(maxPivots);
}

} // namespace rcr
