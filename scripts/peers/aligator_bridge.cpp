// Aligator's ProxDDP on a shooting problem of Crocoddyl, for Python: the index has Aligator's
// library without its Python bindings. Controls with bounds get them as box constraints.
#include <chrono>

#include <aligator/compat/crocoddyl/action-model-wrap.hpp>
#include <aligator/compat/crocoddyl/cost-wrap.hpp>
#include <aligator/compat/crocoddyl/state-wrap.hpp>
#include <aligator/core/callback-base.hpp>
#include <aligator/core/stage-data.hpp>
#include <aligator/core/stage-model.hpp>
#include <aligator/core/traj-opt-problem.hpp>
#include <aligator/modelling/constraints/box-constraint.hpp>
#include <aligator/modelling/state-error.hpp>
#include <aligator/solvers/proxddp/solver-proxddp.hpp>
#include <boost/python.hpp>
#include <crocoddyl/core/optctrl/shooting.hpp>

namespace python = boost::python;
using Eigen::VectorXd;
using Vectors = std::vector<VectorXd>;
using CrocoddylProblem = crocoddyl::ShootingProblemTpl<double>;
using Problem = aligator::TrajOptProblemTpl<double>;
using Stage = aligator::StageModelTpl<double>;
using Wrapper = aligator::compat::croc::ActionModelWrapperTpl<double>;
using Solver = aligator::SolverProxDDPTpl<double>;

namespace {

/// A knot of Crocoddyl's with constraints. Aligator's own wrapper of such knots leaves constraints
/// out, so this one adds their values and Jacobians to what that one computes.
class ConstrainedKnot final : public Stage {
 public:
  explicit ConstrainedKnot(const std::shared_ptr<crocoddyl::ActionModelAbstractTpl<double>>& knot)
      : ConstrainedKnot(Wrapper(knot)) {
    if (!knot->get_has_control_limits()) return;
    const int ndx = static_cast<int>(knot->get_state()->get_ndx());
    addConstraint(aligator::ControlErrorResidualTpl<double>(ndx, static_cast<int>(knot->get_nu())),
                  aligator::BoxConstraintTpl<double>(knot->get_u_lb(), knot->get_u_ub()));
  }

  bool hasDynModel() const override { return false; }

  void evaluate(const ConstVectorRef& x, const ConstVectorRef& u, Data& data) const override {
    knot_.evaluate(x, u, data);
    for (std::size_t i = 0; i < numConstraints(); ++i)
      constraints_.funcs[i]->evaluate(x, u, *data.constraint_data[i]);
  }

  void computeFirstOrderDerivatives(const ConstVectorRef& x, const ConstVectorRef& u,
                                    Data& data) const override {
    knot_.computeFirstOrderDerivatives(x, u, data);
    for (std::size_t i = 0; i < numConstraints(); ++i)
      constraints_.funcs[i]->computeJacobians(x, u, *data.constraint_data[i]);
  }

  void computeSecondOrderDerivatives(const ConstVectorRef&, const ConstVectorRef&,
                                     Data&) const override {}  // the first order brings Hessians

  std::shared_ptr<Data> createData() const override {
    const auto data = knot_.createData();
    for (std::size_t i = 0; i < numConstraints(); ++i)
      data->constraint_data.push_back(constraints_.funcs[i]->createData());
    return data;
  }

 private:
  explicit ConstrainedKnot(const Wrapper& knot) : Stage(knot.cost_, knot.dynamics_), knot_(knot) {}
  Wrapper knot_;
};

Problem translate(const CrocoddylProblem& crocoddyl) {
  std::vector<xyz::polymorphic<Stage>> stages;
  for (const auto& knot : crocoddyl.get_runningModels()) stages.emplace_back(ConstrainedKnot(knot));
  return Problem(
      crocoddyl.get_x0(), stages,
      aligator::compat::croc::CrocCostModelWrapperTpl<double>(crocoddyl.get_terminalModel()));
}

/// Keeps the iterates.
class Recorder final : public aligator::CallbackBaseTpl<double> {
 public:
  using Base = aligator::CallbackBaseTpl<double>;
  void call(const Base::Workspace&, const Base::Results& results) override {
    iterates.append(python::make_tuple(Vectors(results.xs), Vectors(results.us)));
  }
  python::list iterates;
};

/// (states, controls) after each iteration.
python::list iterates(const std::shared_ptr<CrocoddylProblem>& crocoddyl, const Vectors& xs,
                      const Vectors& us, double tolerance, double mu, int iterations) {
  const Problem problem = translate(*crocoddyl);
  Solver solver(tolerance, mu, iterations);
  solver.max_al_iters = iterations;  // by default its outer loop stops after 100
  const auto recorder = std::make_shared<Recorder>();
  solver.registerCallback("recorder", recorder);
  solver.setup(problem);
  solver.run(problem, xs, us);
  return recorder->iterates;
}

/// (converged, iterations, seconds of each repetition, states, controls). Workspaces are allocated
/// before the clock runs.
python::tuple solve(const std::shared_ptr<CrocoddylProblem>& crocoddyl, const Vectors& xs,
                    const Vectors& us, double tolerance, double mu, int iterations, int repeat) {
  const Problem problem = translate(*crocoddyl);
  Solver solver(tolerance, mu, iterations);
  solver.max_al_iters = iterations;  // by default its outer loop stops after 100
  solver.setup(problem);
  python::list seconds;
  bool converged = false;
  for (int i = 0; i < repeat; ++i) {
    const auto began = std::chrono::steady_clock::now();
    converged = solver.run(problem, xs, us);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
    seconds.append(took.count());
  }
  return python::make_tuple(converged, static_cast<int>(solver.results_.num_iters), seconds,
                            Vectors(solver.results_.xs), Vectors(solver.results_.us));
}

}  // namespace

BOOST_PYTHON_MODULE(aligator_bridge) {
  python::def("solve", solve);
  python::def("iterates", iterates);
}
