#pragma once

#include "nlp/interior_point.hpp"

namespace conddp {

/// Chooses the next Hessian of the Lagrangian for an interior-point method, Gauss-Newton or exact,
/// if exact ones are expensive.
///
/// Far from a solution, the exact Hessian is indefinite. The method then adds a multiple of the
/// identity, which shortens steps in all directions. The Gauss-Newton Hessian is convex without it
/// and takes a fraction of the time. Near a solution, the exact Hessian converges quadratically.
///
/// Gauss-Newton Hessians are therefore used until their steps turn out to be poor or their
/// convergence slow, and exact ones until they are regularized. The patience with both doubles
/// whenever exact ones are given up: if neither is good, changing at every step would leave neither
/// the time to make progress.
class HessianAlternation {
 public:
  /// Starts at the first iterate, whose next step is Gauss-Newton.
  void begin(const InteriorPointIterate& first);
  /// Takes every further iterate, which tells how the step to it went.
  void watch(const InteriorPointIterate& iterate);

  bool gauss_newton() const { return gauss_newton_; }

 private:
  void watch_gauss_newton(const InteriorPointIterate& iterate, double error);
  int with_patience(int count) const;
  void change();

  bool gauss_newton_ = true;
  int returns_ = 0;           ///< changes from exact to Gauss-Newton Hessians
  int bad_steps_ = 0;         ///< since the last change
  int iterations_ = 0;        ///< since the current watch on convergence began
  double watched_error_ = 0;  ///< error when that watch began
  double last_error_ = 0;
  double barrier_ = 0;
};

}  // namespace conddp
