#include "solvers/stages/stage_solver.hpp"

namespace conddp {
namespace {

class UnconstrainedStage : public StageSolver {
 public:
  explicit UnconstrainedStage(int max_nu) : factor_(max_nu, max_nu) {}

  bool solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k,
             const LaneBlock& Kt) override {
    return stage.solve_free(factor_, k, Kt);
  }

 private:
  LaneMatrix factor_;
};

}  // namespace

std::unique_ptr<StageSolver> unconstrained_stage(const ShootingProblem& problem) {
  return std::make_unique<UnconstrainedStage>(largest_nu(problem));
}

}  // namespace conddp
