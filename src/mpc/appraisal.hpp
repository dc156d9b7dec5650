#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "mpc/time_line.hpp"
#include "ocp/knot/knot_model.hpp"

namespace conddp {

/// Cost and constraint violation of a plant step, or of the time line's last node.
struct StepFigures {
  double cost = 0;       ///< running cost of the step, or terminal cost
  double violation = 0;  ///< largest violation of a hard constraint
};

/// Evaluates costs and constraints of a time line at states of a plant. The time line must outlive
/// it.
class Appraisal {
 public:
  /// `other_forces`: the plant's contact forces differ from those of the time line's phases. Costs
  /// and constraints on contact forces are then ignored.
  Appraisal(const TimeLine& line, bool other_forces);
  /// Cost and violation of a step of `length` (s) from `time` (s), given its control and its
  /// initial state.
  StepFigures of_step(double time, double length, const double* u, const double* x) const;
  /// Cost and violation at the time line's last node.
  StepFigures of_end(const double* x) const;

 private:
  bool counts(const Residual& residual) const;
  StepFigures figures(const KnotModel& model, const double* parameters) const;

  const TimeLine& line_;
  bool other_forces_;
  std::map<const KnotModel*, std::unique_ptr<KnotBatch<double>>> batches_;
};

/// Ends the loop when a constraint of this node is violated. The node has no control.
struct StopCondition {
  std::shared_ptr<const KnotModel> model;
  std::vector<double> parameters;
};

/// Checks whether a state meets the stop condition; without a condition, no state does. The
/// condition must outlive the check.
class StopCheck {
 public:
  /// Throws std::invalid_argument if the number of parameters differs from the model's.
  explicit StopCheck(const std::optional<StopCondition>& condition);
  bool is_met(const double* x) const { return first_met(x) != nullptr; }
  /// First constraint that the state violates; null if the condition is not met.
  const ConstraintTerm* first_met(const double* x) const;

 private:
  const std::optional<StopCondition>& condition_;
  std::unique_ptr<KnotBatch<double>> batch_;
};

}  // namespace conddp
