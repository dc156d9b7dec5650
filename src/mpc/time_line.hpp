#pragma once

#include <memory>
#include <vector>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Times that differ by less are one, s.
inline constexpr double kSameTime = 1e-9;

inline bool is_before(double a, double b) { return a < b - kSameTime; }

/// A knot of the time line, or what of it lies in a window.
struct TimedKnot {
  int knot;      ///< of the problem
  double begin;  ///< s
  double end;    ///< s; `begin` of an instant
};

/// The knots of a problem by time. Where it is held, its last knot that takes time repeats itself
/// after the end for ever.
class TimeLine {
 public:
  /// Throws std::invalid_argument where knots cannot be cut by time: an initial state or durations
  /// that are free.
  TimeLine(std::shared_ptr<const ShootingProblem> problem, bool held);

  const ShootingProblem& problem() const { return *problem_; }
  /// From here on the numbers of nodes (references, weights, bounds) are those of a problem of the
  /// same structure. Throws std::invalid_argument where it has another one. Allocates nothing.
  void take_numbers(std::shared_ptr<const ShootingProblem> source);
  /// Of a knot, or of the last node.
  KnotNumbers numbers(int node) const {
    const KnotView& view = numbers_->knot(node);
    return {view.dt, view.cost_scale, view.parameters};
  }
  bool is_held() const { return held_; }
  /// When the problem ends, s.
  double end() const { return problem_->times().back(); }
  /// The knot that takes time and contains a time; at the end and after it the last one.
  TimedKnot at(double time) const;
  /// What lies in [from, to) in order: knots, and instants whose time does. Without hold nothing
  /// after the end. Replaces what is in `knots`.
  void cut(double from, double to, std::vector<TimedKnot>& knots) const;
  /// Instants (impulses) at a time, in order: the first one and the one after the last.
  std::pair<int, int> instants_at(double time) const;

 private:
  /// The first knot that ends after a time, or is an instant at it; N where there is none.
  int first_after(double time) const;
  TimedKnot held(double time) const;

  std::shared_ptr<const ShootingProblem> problem_, numbers_;
  bool held_;
  int last_ = 0;  ///< knot that takes time
};

}  // namespace conddp
