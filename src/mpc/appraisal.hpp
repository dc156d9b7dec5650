#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "mpc/time_line.hpp"
#include "ocp/knot/knot_batch.hpp"

namespace conddp {

/// What a time line says of a step of the plant, or of its last node.
struct StepFigures {
  double cost = 0;       ///< the running cost's share; the terminal cost
  double violation = 0;  ///< largest one of a hard constraint
};

/// Costs and constraints of a time line, which has to outlive it, at states of a plant.
class Appraisal {
 public:
  /// `other_forces`: contact forces of the plant are not those of the time line's phases. Then
  /// costs and constraints of contact forces do not count.
  Appraisal(const TimeLine& line, bool other_forces);
  /// Of a step from a time (s) with a length (s), by its control and the state at its begin.
  StepFigures of_step(double time, double length, const double* u, const double* x) const;
  /// Of the time line's last node.
  StepFigures of_end(const double* x) const;

 private:
  bool counts(const Residual& residual) const;
  StepFigures figures(const KnotModel& model, const double* parameters) const;

  const TimeLine& line_;
  bool other_forces_;
  std::map<const KnotModel*, std::unique_ptr<KnotBatch<double>>> batches_;
};

/// Ends the loop where constraints of a node without control do not hold.
struct StopCondition {
  std::shared_ptr<const KnotModel> model;
  std::vector<double> parameters;
};

/// Whether a state meets a condition that ends the loop; none is never met. The condition has to
/// outlive it.
class StopCheck {
 public:
  /// Throws std::invalid_argument where the parameters are not the model's.
  explicit StopCheck(const std::optional<StopCondition>& condition);
  bool is_met(const double* x) const { return first_met(x) != nullptr; }
  /// The constraint that a state violates, the first of several; null where the condition is not
  /// met.
  const ConstraintTerm* first_met(const double* x) const;

 private:
  const std::optional<StopCondition>& condition_;
  std::unique_ptr<KnotBatch<double>> batch_;
};

}  // namespace conddp
