#pragma once

#include "nlp/interior_point.hpp"

namespace conddp {

/// Which Hessian of the Lagrangian an interior-point method gets next, Gauss-Newton's or the exact
/// one, where the latter is dear.
///
/// Far from a solution the exact Hessian is indefinite, and the multiple of the identity that the
/// method then adds shortens steps in all directions; Gauss-Newton's is convex as it is, and takes
/// a fraction of the time. Near a solution the exact one converges quadratically. So Gauss-Newton's
/// is taken until its steps turn out to be poor or its convergence slow, and the exact one until it
/// has been regularised. The patience with both doubles whenever exact ones are given up: where
/// neither is good, changing at every step would leave neither the time to get on.
class HessianAlternation {
 public:
  /// With the first iterate, whose next step is Gauss-Newton's.
  void begin(const InteriorPointIterate& first);
  /// With every further iterate, which says how the step to it went.
  void watch(const InteriorPointIterate& iterate);

  bool gauss_newton() const { return gauss_newton_; }

 private:
  void watch_gauss_newton(const InteriorPointIterate& iterate, double error);
  int with_patience(int count) const;
  void change();

  bool gauss_newton_ = true;
  int returns_ = 0;           ///< from exact Hessians to Gauss-Newton ones
  int bad_steps_ = 0;         ///< since the last change
  int iterations_ = 0;        ///< since the convergence is watched
  double watched_error_ = 0;  ///< when that began
  double last_error_ = 0;
  double barrier_ = 0;
};

}  // namespace conddp
