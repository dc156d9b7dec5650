#pragma once

#include "nlp/symmetric_factorization.hpp"

namespace conddp {

/// While alive, Ipopt's linear solver `name()` is our own factorization. Ipopt does not install the
/// headers of its linear-solver interfaces. It does install a slot for the functions of HSL's MA27,
/// which a user may have as a library and Debian lacks. Only one may exist at a time.
class OwnLinearSolver {
 public:
  explicit OwnLinearSolver(MakeFactorization make);
  ~OwnLinearSolver();
  OwnLinearSolver(const OwnLinearSolver&) = delete;
  OwnLinearSolver& operator=(const OwnLinearSolver&) = delete;

  /// True if this Ipopt has that slot.
  static bool is_possible();
  /// Ipopt's option names of the solver and its pivot tolerances.
  static const char* name() { return "ma27"; }
  static const char* pivot_tolerance() { return "ma27_pivtol"; }
  static const char* largest_pivot_tolerance() { return "ma27_pivtolmax"; }
};

}  // namespace conddp
