#pragma once

#include "solvers/riccati/parametric_segment.hpp"

namespace conddp {

/// The end of a parametric segment, where the true value ½ xᵀ P x + pᵀ x of what follows is known:
/// there θ = (P − W) x + p and x = Lᵀ δx + s + S θ, δx at the segment's first node. With Δ = P − W
/// and a factor −S = G Gᵀ
///   E y = Gᵀ (Δ c + p),  E = I + Gᵀ Δ G,  c = Lᵀ δx + s,  x = c − G y,  θ = Δ x + p.
/// The segment and what follows have a minimum together if and only if E is positive definite,
/// given that the segment has one with W: its reduced Hessian with P is that with W and CᵀΔC more,
/// where C gives x, and −S is C times the inverse of the latter times Cᵀ.
class SegmentJunction {
 public:
  explicit SegmentJunction(int ndx);

  /// After the segment's sweep: the factor G.
  void factor(const ParametricSegment& segment);
  /// After that, with the true value at the segment's end. False where E is not safely positive
  /// definite: the segment's sweep says nothing then.
  bool meet(ParametricSegment& segment, const ValueFunction& next);
  /// After that: what the segment's value at its first node, `own` for θ = 0, becomes as the true
  /// value there, P + L Δ' Lᵀ with Δ' = Δ − Δ G E⁻¹ Gᵀ Δ.
  void form_value(ParametricSegment& segment, const ValueFunction& own, ValueFunction& value);
  /// θ, and the step x at the segment's end, from that at its first node.
  void step(ParametricSegment& segment, const Eigen::VectorXd& dx);
  const Eigen::VectorXd& theta() const { return theta_; }
  const Eigen::VectorXd& dx() const { return dx_; }

 private:
  void normalize(const ParametricSegment& segment);

  int ndx_, rank_ = 0;  ///< of G
  LaneMatrix delta_, Gt_, GtDelta_, E_, work_, product_, sum_;
  LaneMatrix y_;  ///< a row
  Eigen::VectorXd p_, theta_, dx_, rhs_;
};

}  // namespace conddp
