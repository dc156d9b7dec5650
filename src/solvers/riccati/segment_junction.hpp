#pragma once

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

}  // namespace conddp
