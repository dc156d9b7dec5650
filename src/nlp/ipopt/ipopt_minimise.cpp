#include "nlp/ipopt/ipopt_minimise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <new>
#include <optional>
#include <stdexcept>

#include <dlfcn.h>

#include <IpCompoundVector.hpp>
#include <IpIpoptApplication.hpp>
#include <IpIpoptCalculatedQuantities.hpp>
#include <IpIpoptData.hpp>
#include <IpTNLP.hpp>
#include <IpTNLPAdapter.hpp>

#include "base/stopwatch.hpp"
#include "nlp/ipopt/own_linear_solver.hpp"
#include "nlp/ipopt/registered_options.hpp"

namespace conddp {
namespace {

/// While alive, limits a multithreaded OpenBLAS to one thread: sums depend on the number of
/// threads, and answers must not. Any other BLAS is left unchanged.
class OneBlasThread {
 public:
  OneBlasThread();
  ~OneBlasThread();
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

 private:
  int threads_before_ = 0;  ///< 0 if there is nothing to restore
};

/// A function of the BLAS loaded with Ipopt; null if the BLAS lacks a function of this name. The
/// system chooses the BLAS at load time.
template <class Function>
Function* blas_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

OneBlasThread::OneBlasThread() {
  const auto get = blas_function<int()>("openblas_get_num_threads");
  const auto set = blas_function<void(int)>("openblas_set_num_threads");
  if (get == nullptr || set == nullptr || get() == 1) return;
  threads_before_ = get();
  set(1);
}

OneBlasThread::~OneBlasThread() {
  if (threads_before_ > 0) blas_function<void(int)>("openblas_set_num_threads")(threads_before_);
}

using Ipopt::Index;
using Ipopt::Number;
using Ipopt::SmartPtr;
using End = InteriorPointEnd;

/// Ipopt treats this value as infinite.
constexpr double kIpoptInfinity = 2e19;

double as_bound(double value) { return std::clamp(value, -kIpoptInfinity, kIpoptInfinity); }

bool all_finite(const double* values, int n) {
  return Eigen::Map<const Eigen::VectorXd>(values, n).allFinite();
}

/// A NonlinearProgram as an Ipopt TNLP.
class Program : public Ipopt::TNLP {
 public:
  Program(NonlinearProgram& program, const Eigen::VectorXd& start, const PrimalDualPoint* warm,
          const std::function<bool(const InteriorPointIterate&)>& on_iterate,
          InteriorPointAnswer& answer)
      : program_(program),
        start_(start),
        warm_(warm),
        on_iterate_(on_iterate),
        answer_(answer),
        y_(start) {}

  /// Sets Ipopt's own adapter of this program, which extracts the variables from Ipopt's vectors.
  void set_adapter(Ipopt::TNLPAdapter* adapter) { adapter_ = adapter; }

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian,
                    IndexStyleEnum& style) override {
    n = program_.variables();
    m = program_.rows();
    jacobian = program_.jacobian_structure().size();
    hessian = program_.hessian_structure().size();
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* row_lower,
                       Number* row_upper) override {
    for (int i = 0; i < n; ++i) {
      lower[i] = as_bound(program_.lower()[i]);
      upper[i] = as_bound(program_.upper()[i]);
    }
    for (int i = 0; i < m; ++i) {
      row_lower[i] = as_bound(program_.row_lower()[i]);
      row_upper[i] = as_bound(program_.row_upper()[i]);
    }
    return true;
  }

  bool get_starting_point(Index n, bool init_y, Number* y, bool init_bounds, Number* lower,
                          Number* upper, Index m, bool init_rows, Number* rows) override {
    if (init_y) std::copy_n(start_.data(), n, y);
    if (init_bounds && warm_ != nullptr) {
      std::copy_n(warm_->lower.data(), n, lower);
      std::copy_n(warm_->upper.data(), n, upper);
    }
    if (init_rows && warm_ != nullptr) std::copy_n(warm_->rows.data(), m, rows);
    return true;
  }

  bool eval_f(Index, const Number* y, bool, Number& value) override {
    const Stopwatch watch(answer_.evaluation_seconds);
    program_.set_point(y);
    value = program_.objective();
    return std::isfinite(value);
  }
  bool eval_grad_f(Index n, const Number* y, bool, Number* gradient) override {
    const Stopwatch watch(answer_.evaluation_seconds);
    program_.set_point(y);
    program_.gradient(gradient);
    return all_finite(gradient, n);
  }
  bool eval_g(Index, const Number* y, bool, Index m, Number* values) override {
    const Stopwatch watch(answer_.evaluation_seconds);
    program_.set_point(y);
    program_.constraints(values);
    return all_finite(values, m);
  }
  bool eval_jac_g(Index, const Number* y, bool, Index, Index entries, Index* rows, Index* columns,
                  Number* values) override {
    if (values == nullptr) {
      copy(program_.jacobian_structure(), rows, columns);
      return true;
    }
    const Stopwatch watch(answer_.evaluation_seconds);
    program_.set_point(y);
    program_.jacobian(values);
    return all_finite(values, entries);
  }
  bool eval_h(Index, const Number* y, bool, Number weight, Index, const Number* multipliers, bool,
              Index entries, Index* rows, Index* columns, Number* values) override {
    if (values == nullptr) {
      copy(program_.hessian_structure(), rows, columns);
      return true;
    }
    const Stopwatch watch(answer_.evaluation_seconds);
    program_.set_point(y);
    program_.hessian(weight, multipliers, values);
    return all_finite(values, entries);
  }

  bool intermediate_callback(Ipopt::AlgorithmMode mode, Index iteration, Number objective,
                             Number infeasibility, Number dual_infeasibility, Number barrier,
                             Number step_norm, Number regularization, Number, Number step,
                             Index trials, const Ipopt::IpoptData* data,
                             Ipopt::IpoptCalculatedQuantities* quantities) override {
    const bool restoration = mode == Ipopt::RestorationPhaseMode;
    SmartPtr<const Ipopt::Vector> x = data->curr()->x();
    // The restoration phase appends its own slacks to the variables.
    if (restoration)
      if (const auto* parts = dynamic_cast<const Ipopt::CompoundVector*>(Ipopt::GetRawPtr(x)))
        x = parts->GetComp(0);
    adapter_->ResortX(*x, y_.data());
    answer_.barrier = barrier;
    return on_iterate_({.iteration = iteration,
                        .restoration = restoration,
                        .objective = objective,
                        .infeasibility = infeasibility,
                        .dual_infeasibility = dual_infeasibility,
                        .complementarity = quantities->curr_complementarity(0.0, Ipopt::NORM_MAX),
                        .barrier = barrier,
                        .step = step,
                        .step_norm = step_norm,
                        .regularization = regularization,
                        .trials = trials,
                        .y = y_.data()});
  }

  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* y, const Number* lower,
                         const Number* upper, Index m, const Number*, const Number* rows, Number,
                         const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    PrimalDualPoint& point = answer_.point;
    point.y = Eigen::Map<const Eigen::VectorXd>(y, n);
    point.lower = Eigen::Map<const Eigen::VectorXd>(lower, n);
    point.upper = Eigen::Map<const Eigen::VectorXd>(upper, n);
    point.rows = Eigen::Map<const Eigen::VectorXd>(rows, m);
  }

 private:
  static void copy(const Sparsity& structure, Index* rows, Index* columns) {
    std::copy(structure.rows.begin(), structure.rows.end(), rows);
    std::copy(structure.columns.begin(), structure.columns.end(), columns);
  }

  NonlinearProgram& program_;
  const Eigen::VectorXd& start_;
  const PrimalDualPoint* warm_;
  const std::function<bool(const InteriorPointIterate&)>& on_iterate_;
  InteriorPointAnswer& answer_;
  Ipopt::TNLPAdapter* adapter_ = nullptr;
  Eigen::VectorXd y_;
};

void set_option(Ipopt::OptionsList& list, const std::string& name, const IpoptValue& value) {
  if (const auto fault = check_registered_option(name, value))
    throw std::invalid_argument(fault->message);
  if (const auto* text = std::get_if<std::string>(&value)) {
    list.SetStringValue(name, *text);
    return;
  }
  const double number =
      std::holds_alternative<int>(value) ? std::get<int>(value) : std::get<double>(value);
  if (is_registered_integer(name))
    list.SetIntegerValue(name, static_cast<int>(number));
  else
    list.SetNumericValue(name, number);
}

/// Meaning of a return code.
struct Meaning {
  Ipopt::ApplicationReturnStatus code;
  End end;
  const char* message;
};
constexpr std::array kMeanings = {
    Meaning{Ipopt::Solve_Succeeded, End::solved, "its tolerances hold"},
    Meaning{Ipopt::Feasible_Point_Found, End::solved, "a feasible point is found"},
    Meaning{Ipopt::Solved_To_Acceptable_Level, End::acceptable,
            "only its looser, acceptable tolerances can be reached"},
    Meaning{Ipopt::User_Requested_Stop, End::stopped, "stopped"},
    Meaning{Ipopt::Maximum_Iterations_Exceeded, End::max_iterations, "the iterations are used up"},
    Meaning{Ipopt::Maximum_CpuTime_Exceeded, End::time_limit, "its processor time is used up"},
    Meaning{Ipopt::Infeasible_Problem_Detected, End::infeasible,
            "it converged to a point of locally least violation"},
    Meaning{Ipopt::Search_Direction_Becomes_Too_Small, End::no_step,
            "the search direction becomes too small"},
    Meaning{Ipopt::Restoration_Failed, End::no_step,
            "the restoration phase finds no better feasible point"},
    Meaning{Ipopt::Error_In_Step_Computation, End::no_factorization,
            "the step cannot be computed, whatever the regularization"},
    Meaning{Ipopt::Diverging_Iterates, End::diverging, "iterates grow beyond all bounds"},
    Meaning{Ipopt::Invalid_Number_Detected, End::not_finite, "a value or derivative is not finite"},
    Meaning{Ipopt::Not_Enough_Degrees_Of_Freedom, End::infeasible,
            "there are more equations than variables"},
};

/// Approximate minimum fill, and no permutation by the size of entries.
constexpr std::array<std::pair<const char*, int>, 2> kMinimumFill = {
    {{"mumps_pivot_order", 2}, {"mumps_permuting_scaling", 0}}};

/// Ratio of a pivot to the largest entry of its column: initially, and if steps are inaccurate.
constexpr double kPivotTolerance = 1e-6, kLargestPivotTolerance = 0.1;

constexpr double kSmallestWarmBarrier = 1e-13;

/// Ipopt without MUMPS does not know these options.
void set_minimum_fill(Ipopt::OptionsList& list) {
  for (const auto& [name, value] : kMinimumFill)
    if (!check_registered_option(name, value)) list.SetIntegerValue(name, value);
}

/// True if an option configures the linear solver.
bool is_of_linear_solver(const std::string& name) {
  return name == "linear_solver" || name == "linear_system_scaling" || name.starts_with("mumps_");
}

bool wants_own_linear_solver(const InteriorPointSettings& settings) {
  return settings.make_factorization != nullptr && OwnLinearSolver::is_possible() &&
         std::none_of(settings.options.begin(), settings.options.end(),
                      [](const auto& option) { return is_of_linear_solver(option.first); });
}

void set_own_linear_solver(Ipopt::OptionsList& list) {
  list.SetStringValue("linear_solver", OwnLinearSolver::name());
  list.SetStringValue("linear_system_scaling", "none");
  list.SetNumericValue(OwnLinearSolver::pivot_tolerance(), kPivotTolerance);
  list.SetNumericValue(OwnLinearSolver::largest_pivot_tolerance(), kLargestPivotTolerance);
}

void set_warm_start(Ipopt::OptionsList& list, const InteriorPointSettings& settings) {
  list.SetStringValue("warm_start_init_point", "yes");
  list.SetNumericValue("mu_init", std::max(settings.warm_barrier, kSmallestWarmBarrier));
  for (const char* push :
       {"bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac", "mult_bound_push"})
    list.SetNumericValue(std::string("warm_start_") + push, settings.warm_push);
}

void set_options(Ipopt::OptionsList& list, const InteriorPointSettings& settings) {
  list.SetStringValue("sb", "yes");
  list.SetIntegerValue("print_level", 0);
  list.SetNumericValue("bound_relax_factor", 0);
  list.SetIntegerValue("max_iter", settings.max_iterations);
  list.SetNumericValue("tol", settings.tolerance);
  list.SetNumericValue("dual_inf_tol", settings.dual_tolerance);
  list.SetNumericValue("constr_viol_tol", settings.violation_tolerance);
  list.SetNumericValue("compl_inf_tol", settings.complementarity_tolerance);
  list.SetNumericValue("acceptable_constr_viol_tol", settings.dual_tolerance);
  if (settings.minimum_fill) set_minimum_fill(list);
  for (const auto& [name, value] : settings.options) set_option(list, name, value);
  if (settings.warm != nullptr) set_warm_start(list, settings);
}

}  // namespace

InteriorPointAnswer ipopt_minimise(
    NonlinearProgram& program, const Eigen::VectorXd& start, const InteriorPointSettings& settings,
    const std::function<bool(const InteriorPointIterate&)>& on_iterate) {
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  const OneBlasThread one_thread;
  std::optional<OwnLinearSolver> own_linear_solver;
  const SmartPtr<Ipopt::IpoptApplication> application = new Ipopt::IpoptApplication(false, false);
  set_options(*application->Options(), settings);
  if (wants_own_linear_solver(settings)) {
    own_linear_solver.emplace(settings.make_factorization);
    set_own_linear_solver(*application->Options());
  }
  // With an empty name, Ipopt does not read a file ipopt.opt in the working folder.
  if (application->Initialize("") != Ipopt::Solve_Succeeded)
    throw std::invalid_argument("Ipopt does not accept its options");

  InteriorPointAnswer answer;
  answer.point.y = start;
  answer.point.rows = Eigen::VectorXd::Zero(program.rows());
  answer.point.lower = answer.point.upper = Eigen::VectorXd::Zero(program.variables());
  const SmartPtr<Program> view = new Program(program, start, settings.warm, on_iterate, answer);
  const SmartPtr<Ipopt::TNLPAdapter> adapter =
      new Ipopt::TNLPAdapter(Ipopt::GetRawPtr(view), Ipopt::ConstPtr(application->Jnlst()));
  view->set_adapter(Ipopt::GetRawPtr(adapter));
  const Ipopt::ApplicationReturnStatus code = application->OptimizeNLP(Ipopt::GetRawPtr(adapter));
  if (code == Ipopt::Insufficient_Memory) throw std::bad_alloc();
  if (code == Ipopt::Invalid_Option)
    throw std::invalid_argument("Ipopt does not accept its options");
  const auto meaning = std::find_if(kMeanings.begin(), kMeanings.end(),
                                    [&](const Meaning& m) { return m.code == code; });
  answer.end = meaning == kMeanings.end() ? End::failed : meaning->end;
  answer.message =
      meaning == kMeanings.end() ? "it stopped with an internal error" : meaning->message;
  return answer;
}

}  // namespace conddp
