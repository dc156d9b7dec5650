#pragma once

#include <map>
#include <memory>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Evaluates nodes of a problem one by one, with one workspace per model.
class NodeEvaluation {
 public:
  explicit NodeEvaluation(const ShootingProblem& problem) : problem_(problem) {}

  /// Evaluates a node at a state and a control (null at the terminal node). The result remains
  /// valid until another node of the same model is evaluated.
  const KnotWorkspace<double>& at(int node, const double* x, const double* u);
  /// Evaluates a node with derivatives, except Hessians.
  const KnotWorkspace<double>& derivatives_at(int node, const double* x, const double* u);
  /// Evaluates a node at its state and control in a trajectory.
  const KnotWorkspace<double>& at(int node, const Trajectory& trajectory);

 private:
  KnotInput<double> input(int node, const double* x, const double* u) const;
  KnotWorkspace<double>& workspace(const KnotModel& model);

  const ShootingProblem& problem_;
  std::map<const KnotModel*, std::unique_ptr<KnotWorkspace<double>>> work_;
};

}  // namespace conddp
