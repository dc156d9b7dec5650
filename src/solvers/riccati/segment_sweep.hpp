#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "solvers/riccati/parametric_segment.hpp"

namespace conddp {

/// The end of a parametric segment, where the true value ½ xᵀ P x + pᵀ x of the following knots is
/// known. There θ = (P − W) x + p and x = Lᵀ δx + s + S θ, with δx at the segment's first node.
/// With Δ = P − W and a factor −S = G Gᵀ
///   E y = Gᵀ (Δ c + p),  E = I + Gᵀ Δ G,  c = Lᵀ δx + s,  x = c − G y,  θ = Δ x + p.
/// If the segment has a minimum with W, then the segment and the following knots have a common
/// minimum if and only if E is positive definite. The reduced Hessian with P is the one with W plus
/// CᵀΔC, where C maps to x, and −S is C times the inverse of the latter times Cᵀ.
class SegmentJunction {
 public:
  explicit SegmentJunction(int ndx);

  /// Computes the factor G, after the segment's sweep.
  void factor(const ParametricSegment& segment);
  /// Joins the segment to the true value at its end, after factor(). False if E is not safely
  /// positive definite; the segment's sweep is invalid then.
  bool meet(ParametricSegment& segment, const ValueFunction& next);
  /// Forms the true value at the segment's first node, after meet(), from the segment's value `own`
  /// for θ = 0: P + L Δ' Lᵀ with Δ' = Δ − Δ G E⁻¹ Gᵀ Δ.
  void form_value(ParametricSegment& segment, const ValueFunction& own, ValueFunction& value);
  /// Computes θ and the step x at the segment's end from the step at its first node.
  void step(ParametricSegment& segment, const Eigen::VectorXd& dx);
  const Eigen::VectorXd& theta() const { return theta_; }
  const Eigen::VectorXd& dx() const { return dx_; }

 private:
  void normalize(const ParametricSegment& segment);

  int ndx_, rank_ = 0;  ///< rank of G
  LaneMatrix delta_, Gt_, GtDelta_, E_, work_, product_, sum_;
  LaneMatrix y_;  ///< a single row
  Eigen::VectorXd p_, theta_, dx_, rhs_;
};

/// Number of segments of the horizon, and number of threads that sweep them. Results depend on the
/// number of segments only, up to rounding.
struct Segments {
  int count = 1;
  int threads = 1;
};

/// A Riccati sweep by segments, which can run in parallel. All segments but the last are swept
/// parametrically (ParametricSegment); junctions (SegmentJunction) then find the states and
/// co-states at their ends. The policy's step through the linear model therefore equals that of the
/// sweep from end to start. The weights at the segment ends are the values of the previous sweep.
/// Gains are then near those of the sweep from end to start, and equal to them once the values
/// settle.
class SegmentSweep {
 public:
  SegmentSweep(const ShootingProblem& problem, const Segments& segments);
  ~SegmentSweep();

  /// First knots of the segments, followed by the number of knots. There may be as many segments as
  /// knots. A knot of a parametric segment takes about twice the work, so the last segment is twice
  /// as long as the others.
  static std::vector<int> split(int knots, int segments);

  /// Takes the values of a whole sweep as weights.
  void start_from(const std::vector<ValueFunction>& values);
  /// Sweeps without regularization, with an affine policy. Returns the knot of a stage that is not
  /// finite or lacks a minimum, or −1 on success. Returns nothing if only a whole sweep can decide:
  /// before the first whole sweep, and if the values have changed too much since the previous
  /// sweep.
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
  std::vector<SegmentJunction> junctions_;   ///< at their ends
  std::vector<char> swept_;
  StageSweep last_;
  int bad_knot_ = -1;
  std::vector<ValueFunction> true_values_;  ///< at the ends of segments
  Eigen::VectorXd start_;
  std::unique_ptr<Team> team_;
};

}  // namespace conddp
