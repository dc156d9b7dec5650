#pragma once

#include <vector>

#include "output/mpc/loop_files.hpp"

namespace conddp {

/// A plan that was in force from a tick on, at some of its nodes.
struct RecordedPlan {
  double from = 0;                     ///< time of the tick, s
  std::vector<double> times;           ///< of the nodes, s; empty under the fallback
  std::vector<std::vector<double>> x;  ///< one a node
};

/// Keeps plans of a loop for its page: of some ticks where there are many.
class PlanRecorder {
 public:
  explicit PlanRecorder(const LoopTask& task);
  /// To be called after each tick.
  void record(const Mpc& mpc);
  const std::vector<RecordedPlan>& plans() const { return plans_; }

 private:
  int every_;  ///< one tick of so many
  std::vector<RecordedPlan> plans_;
};

/// What the page of a closed loop is made from: the plant's motion like that of a solution, ticks
/// with the times that they took, events, and plans as bodies and as ways. Long loops are thinned
/// out.
OrderedJson loop_report(const LoopRun& run, const std::vector<RecordedPlan>& plans);

}  // namespace conddp
