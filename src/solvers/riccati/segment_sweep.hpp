#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "solvers/riccati/parametric_segment.hpp"
#include "solvers/riccati/segment_junction.hpp"

namespace conddp {

/// Into how many segments sweeps cut the horizon, and how many threads sweep them. Results depend
/// on the former alone, to rounding.
struct Segments {
  int count = 1;
  int threads = 1;
};

/// A Riccati sweep by segments, which can be swept side by side: all but the last one
/// parametrically (ParametricSegment), after which junctions (SegmentJunction) find the states and
/// co-states at their ends. So the policy's step through the linear model is that of the sweep from
/// end to start. As weights at the ends of segments the values of the sweep before are taken, so
/// that gains are near those of that sweep, and equal as values settle.
class SegmentSweep {
 public:
  SegmentSweep(const ShootingProblem& problem, const Segments& segments);
  ~SegmentSweep();

  /// The first knots of up to as many segments as knots, and the number of knots. A knot of a
  /// parametric segment takes about twice the work of another; so the last segment is twice as long
  /// as the others.
  static std::vector<int> split(int knots, int segments);

  /// Takes the values that a whole sweep has found as weights.
  void start_from(const std::vector<ValueFunction>& values);
  /// Sweeps without regularisation with a policy that is affine. Returns the knot whose stage has
  /// no minimum or is not finite, −1 where all went well, and nothing where only a whole sweep can
  /// tell: before the first of them, and where the values have changed too much since the one
  /// before.
  std::optional<int> run(const SweptHorizon& horizon, StageSolver& stages, Feedback& feedback,
                         std::vector<ValueFunction>& values, std::vector<Eigen::MatrixXd>& Quu);

 private:
  struct Team;
  void sweep_all(const SweptHorizon& horizon, StageSolver& stages, Feedback& feedback,
                 std::vector<ValueFunction>& values, std::vector<Eigen::MatrixXd>& Quu);
  int sweep_last(const SweptHorizon& horizon, StageSolver& stages, Feedback& feedback,
                 std::vector<ValueFunction>& values, std::vector<Eigen::MatrixXd>& Quu);
  bool join(const std::vector<ValueFunction>& values);

  int knots_;
  bool started_ = false;
  std::vector<ParametricSegment> segments_;  ///< all but the last
  std::vector<SegmentJunction> junctions_;   ///< their ends
  std::vector<char> swept_;
  StageSweep last_;
  int bad_knot_ = -1;
  std::vector<ValueFunction> true_values_;  ///< at the ends of segments
  Eigen::VectorXd start_;
  std::unique_ptr<Team> team_;
};

}  // namespace conddp
