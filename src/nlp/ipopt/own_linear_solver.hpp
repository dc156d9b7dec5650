#pragma once

#include "nlp/symmetric_factorization.hpp"

namespace conddp {

/// While it lives, Ipopt's linear solver of the name `name()` is a factorization of ours. Ipopt's
/// interfaces for linear solvers are not among its installed headers; what is, is a place for the
/// functions of HSL's MA27, which a user may have as a library and Debian has not. One at a time.
class OwnLinearSolver {
 public:
  explicit OwnLinearSolver(MakeFactorization make);
  ~OwnLinearSolver();
  OwnLinearSolver(const OwnLinearSolver&) = delete;
  OwnLinearSolver& operator=(const OwnLinearSolver&) = delete;

  /// Whether this Ipopt has that place.
  static bool is_possible();
  /// What Ipopt's options call it, and its limits of pivots.
  static const char* name() { return "ma27"; }
  static const char* pivot_tolerance() { return "ma27_pivtol"; }
  static const char* largest_pivot_tolerance() { return "ma27_pivtolmax"; }
};

}  // namespace conddp
