#pragma once

#include <memory>
#include <vector>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Times closer than this are equal, s.
inline constexpr double kSameTime = 1e-9;

inline bool is_before(double a, double b) { return a < b - kSameTime; }

/// A knot of the time line, or the part of it in a window.
struct TimedKnot {
  int knot;      ///< index in the problem
  double begin;  ///< s
  double end;    ///< s; equals `begin` for an instant
};

/// Knots of a problem by time. If held, the time line repeats its last knot that takes time without
/// end.
class TimeLine {
 public:
  /// Throws std::invalid_argument if time cannot cut the knots: with a free initial state or free
  /// durations.
  TimeLine(std::shared_ptr<const ShootingProblem> problem, bool held);

  const ShootingProblem& problem() const { return *problem_; }
  /// From now on, takes the numbers of nodes (references, weights, bounds) from a problem of the
  /// same structure. Throws std::invalid_argument if the structure differs. Allocates nothing.
  void take_numbers(std::shared_ptr<const ShootingProblem> source);
  /// Numbers of a knot, or of the last node.
  KnotNumbers numbers(int node) const {
    const KnotView& view = numbers_->knot(node);
    return {view.dt, view.cost_scale, view.parameters};
  }
  bool is_held() const { return held_; }
  /// End of the problem, s.
  double end() const { return problem_->times().back(); }
  /// Knot that takes time and contains `time`; the last one at the end and after it.
  TimedKnot at(double time) const;
  /// Writes the knots in [from, to) in order, clipped to the interval, with the instants inside it.
  /// Without hold, nothing follows the end. Replaces the content of `knots`.
  void cut(double from, double to, std::vector<TimedKnot>& knots) const;
  /// Instants (impulses) at a time, in order: the first one and one past the last.
  std::pair<int, int> instants_at(double time) const;

 private:
  /// First knot that ends after `time` or is an instant at it; N if none exists.
  int first_after(double time) const;
  TimedKnot held(double time) const;

  std::shared_ptr<const ShootingProblem> problem_, numbers_;
  bool held_;
  int last_ = 0;  ///< last knot that takes time
};

}  // namespace conddp
