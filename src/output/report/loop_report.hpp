#pragma once

#include <vector>

#include "output/mpc/loop_files.hpp"

namespace conddp {

/// A plan in force from a tick on, at some of its nodes.
struct RecordedPlan {
  double from = 0;                     ///< time of the tick, s
  std::vector<double> times;           ///< of the nodes, s; empty under the fallback
  std::vector<std::vector<double>> x;  ///< one per node
  std::vector<std::vector<double>> u;  ///< at the node or, at the last one, before it
};

/// Records plans of a loop for its page, thinned out if there are many ticks.
class PlanRecorder {
 public:
  explicit PlanRecorder(const LoopTask& task);
  /// Called after each tick.
  void record(const Mpc& mpc);
  const std::vector<RecordedPlan>& plans() const { return plans_; }

 private:
  int every_;  ///< recording interval in ticks
  std::vector<RecordedPlan> plans_;
};

/// Data of a closed loop's page: the plant's motion as for a solution, ticks with their computation
/// times, events, and plans as bodies and as paths. Long loops are thinned out.
OrderedJson loop_report(const LoopRun& run, const std::vector<RecordedPlan>& plans);

}  // namespace conddp
