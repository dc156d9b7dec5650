#include "nlp/interior_point.hpp"

#include <cmath>
#include <filesystem>
#include <limits>

#include <dlfcn.h>

#include <gtest/gtest.h>

#include "nlp/chain_factorization.hpp"
#include "nlp/transcription.hpp"
#include "support/constrained_problems.hpp"
#include "support/expression_systems.hpp"
#include "support/nlp_derivatives.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

using End = InteriorPointEnd;

/// Problem 71 of Hock and Schittkowski (1981): minimize y₀ y₃ (y₀ + y₁ + y₂) + y₂ subject to y₀ y₁
/// y₂ y₃ ≥ 25, ‖y‖² = 40, and 1 ≤ y ≤ 5. Its optimum is 17.0140173.
class HockSchittkowski71 : public NonlinearProgram {
 public:
  explicit HockSchittkowski71(double square = 40) {
    lower_ = Eigen::VectorXd::Constant(4, 1);
    upper_ = Eigen::VectorXd::Constant(4, 5);
    row_lower_ = Eigen::Vector2d(25, square);
    row_upper_ = Eigen::Vector2d(std::numeric_limits<double>::infinity(), square);
    for (int r = 0; r < 2; ++r)
      for (int c = 0; c < 4; ++c) jacobian_.add(r, c);
    for (int c = 0; c < 4; ++c)
      for (int r = c; r < 4; ++r) hessian_.add(r, c);
  }
  void set_point(const double* y) override { y_ = Eigen::Vector4d(y); }
  double objective() override {
    if (broken) return std::nan("");
    return y_[0] * y_[3] * (y_[0] + y_[1] + y_[2]) + y_[2];
  }
  void gradient(double* out) override {
    out[0] = y_[3] * (2 * y_[0] + y_[1] + y_[2]);
    out[1] = y_[0] * y_[3];
    out[2] = y_[0] * y_[3] + 1;
    out[3] = y_[0] * (y_[0] + y_[1] + y_[2]);
  }
  void constraints(double* out) override {
    out[0] = y_.prod();
    out[1] = y_.squaredNorm();
  }
  void jacobian(double* out) override {
    for (int c = 0; c < 4; ++c) {
      out[c] = y_.prod() / y_[c];
      out[4 + c] = 2 * y_[c];
    }
  }
  void hessian(double weight, const double* m, double* out) override {
    Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
    H(0, 0) = weight * 2 * y_[3];
    H(1, 0) = H(2, 0) = weight * y_[3];
    H(3, 0) = weight * (2 * y_[0] + y_[1] + y_[2]);
    H(3, 1) = H(3, 2) = weight * y_[0];
    for (int c = 0; c < 4; ++c)
      for (int r = c; r < 4; ++r) {
        H(r, c) += r == c ? 2 * m[1] : m[0] * y_.prod() / (y_[r] * y_[c]);
        *out++ = H(r, c);
      }
  }

  bool broken = false;

 private:
  Eigen::Vector4d y_;
};

const Eigen::VectorXd kStart = Eigen::Vector4d(1, 5, 5, 1);

bool go_on(const InteriorPointIterate&) { return true; }

TEST(InteriorPoint, FindsAPublishedOptimumSilently) {
  HockSchittkowski71 program;
  ::testing::internal::CaptureStdout();
  int iterates = 0;
  const InteriorPointAnswer answer =
      minimise(program, kStart, {}, [&](const InteriorPointIterate& iterate) {
        EXPECT_EQ(iterate.iteration, iterates++);
        return true;
      });
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(answer.end, End::solved);
  program.set_point(answer.point.y.data());
  EXPECT_NEAR(program.objective(), 17.0140173, 1e-6);
  EXPECT_GT(iterates, 3);
  // ∇f + Jᵀ rows − lower + upper = 0.
  Eigen::VectorXd gradient(4), jacobian(8);
  program.gradient(gradient.data());
  program.jacobian(jacobian.data());
  gradient += answer.point.rows[0] * jacobian.head(4) + answer.point.rows[1] * jacobian.tail(4);
  gradient += answer.point.upper - answer.point.lower;
  EXPECT_LE(gradient.lpNorm<Eigen::Infinity>(), 1e-6);
  EXPECT_GT(answer.point.lower[0], 0.5);
}

TEST(InteriorPoint, MinimumFillOrderingFindsTheSamePoint) {
  HockSchittkowski71 program;
  const InteriorPointAnswer answer = minimise(program, kStart, {}, go_on);
  const InteriorPointAnswer ordered = minimise(program, kStart, {.minimum_fill = true}, go_on);
  EXPECT_EQ(ordered.end, End::solved);
  EXPECT_LE((ordered.point.y - answer.point.y).lpNorm<Eigen::Infinity>(), 1e-12);
}

int factorizations_made = 0;

std::unique_ptr<SymmetricFactorization> make_counted() {
  ++factorizations_made;
  return ChainFactorization::make();
}

TEST(InteriorPoint, OwnFactorizationFindsTheSamePoint) {
  HockSchittkowski71 program;
  const InteriorPointAnswer answer = minimise(program, kStart, {}, go_on);
  factorizations_made = 0;
  const InteriorPointSettings ours = {.make_factorization = make_counted};
  const InteriorPointAnswer same = minimise(program, kStart, ours, go_on);
  EXPECT_EQ(same.end, End::solved);
  EXPECT_EQ(factorizations_made, 1);
  EXPECT_LE((same.point.y - answer.point.y).lpNorm<Eigen::Infinity>(), 1e-12);
  EXPECT_LE((same.point.rows - answer.point.rows).lpNorm<Eigen::Infinity>(), 1e-9);
}

TEST(InteriorPoint, UsesTheLinearSolverOfTheOption) {
  HockSchittkowski71 program;
  factorizations_made = 0;
  for (const auto& [name, value] :
       IpoptOptions{{"linear_solver", "mumps"}, {"mumps_pivtol", 1e-5}}) {
    const InteriorPointSettings settings = {.make_factorization = make_counted,
                                            .options = {{name, value}}};
    EXPECT_EQ(minimise(program, kStart, settings, go_on).end, End::solved) << name;
  }
  EXPECT_EQ(factorizations_made, 0);
}

TEST(InteriorPoint, ReadsNoFileOfTheWorkingFolder) {
  const auto before = std::filesystem::current_path();
  const TemporaryFolder folder;
  folder.write("ipopt.opt", "max_iter 1\n");
  std::filesystem::current_path(folder.path());
  HockSchittkowski71 program;
  const InteriorPointAnswer answer = minimise(program, kStart, {}, go_on);
  std::filesystem::current_path(before);
  EXPECT_EQ(answer.end, End::solved);
}

TEST(InteriorPoint, EndsHaveTheirNames) {
  HockSchittkowski71 program;
  EXPECT_EQ(minimise(program, kStart, {.max_iterations = 2}, go_on).end, End::max_iterations);
  const auto stop = [](const InteriorPointIterate& i) { return i.iteration < 3; };
  const InteriorPointAnswer stopped = minimise(program, kStart, {}, stop);
  EXPECT_EQ(stopped.end, End::stopped);
  EXPECT_GT(stopped.barrier, 0);
  EXPECT_EQ(stopped.point.y.size(), 4);
  HockSchittkowski71 contradiction(3);  // ‖y‖² = 3 contradicts y ≥ 1
  EXPECT_EQ(minimise(contradiction, kStart, {}, go_on).end, End::infeasible);
  program.broken = true;
  EXPECT_EQ(minimise(program, kStart, {}, go_on).end, End::not_finite);
}

TEST(InteriorPoint, ContinuesFromAnEarlierAnswer) {
  HockSchittkowski71 program;
  int cold = 0, warm = 0;
  const InteriorPointAnswer first =
      minimise(program, kStart, {}, [&](const InteriorPointIterate&) { return ++cold > 0; });
  const InteriorPointAnswer second =
      minimise(program, first.point.y, {.warm = &first.point, .warm_barrier = first.barrier},
               [&](const InteriorPointIterate&) { return ++warm > 0; });
  EXPECT_EQ(second.end, End::solved);
  EXPECT_LE(warm, 3);
  EXPECT_LT(warm, cold);
}

TEST(InteriorPoint, OptionsReachTheLibrary) {
  HockSchittkowski71 program;
  EXPECT_EQ(minimise(program, kStart,
                     {.options = {{"tol", 1e3},
                                  {"dual_inf_tol", 1e6},
                                  {"constr_viol_tol", 1e6},
                                  {"compl_inf_tol", 1e6}}},
                     [](const InteriorPointIterate& i) { return i.iteration == 0; })
                .end,
            End::solved);
  EXPECT_THROW(minimise(program, kStart, {.options = {{"tolerance", 1e-3}}}, go_on),
               std::invalid_argument);
}

TEST(IpoptOptions, AreCheckedByNameAndType) {
  using Kind = IpoptOptionFault::Kind;
  EXPECT_FALSE(check_ipopt_option("mu_strategy", "adaptive"));
  EXPECT_FALSE(check_ipopt_option("tol", 1e-6));
  EXPECT_FALSE(check_ipopt_option("tol", 1));
  EXPECT_FALSE(check_ipopt_option("acceptable_iter", 3));
  EXPECT_FALSE(check_ipopt_option("acceptable_iter", 3.0));
  EXPECT_EQ(check_ipopt_option("mu_stratgy", "adaptive")->kind, Kind::unknown);
  EXPECT_EQ(check_ipopt_option("print_level", 5)->kind, Kind::reserved);
  const auto message = [](const char* name, const IpoptValue& value) {
    const auto fault = check_ipopt_option(name, value);
    EXPECT_TRUE(fault && fault->kind == Kind::value) << name;
    return fault ? fault->message : "";
  };
  EXPECT_EQ(message("mu_strategy", "fast"),
            "Ipopt's option 'mu_strategy' must be one of monotone, adaptive");
  EXPECT_EQ(message("mu_strategy", 1),
            "Ipopt's option 'mu_strategy' must be one of monotone, adaptive");
  EXPECT_EQ(message("tol", -1.0), "Ipopt's option 'tol' must be more than 0, not -1");
  EXPECT_EQ(message("tol", "small"), "Ipopt's option 'tol' must be a number");
  EXPECT_EQ(message("acceptable_iter", 2.5),
            "Ipopt's option 'acceptable_iter' must be a whole number, not 2.5");
  EXPECT_EQ(message("acceptable_iter", -2),
            "Ipopt's option 'acceptable_iter' must be at least 0, not -2");
  EXPECT_NE(std::find(ipopt_option_names().begin(), ipopt_option_names().end(), "mu_init"),
            ipopt_option_names().end());
  EXPECT_EQ(std::find(ipopt_option_names().begin(), ipopt_option_names().end(), "max_iter"),
            ipopt_option_names().end());
}

// Initial multipliers, compared with the equations of weighted least squares.
using testing::jacobian_times;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A program at its guess.
struct First {
  explicit First(const ShootingProblem& of)
      : problem(of), evaluator(of, 1), program(of, evaluator, {}) {
    std::mt19937_64 engine(3);
    Trajectory guess = problem.create_trajectory();
    for (int k = 0; k < problem.knots(); ++k) {
      guess.u(k) = testing::random_vector(problem.nu(k), engine);
      guess.x(k + 1) = guess.x(k) + 0.1 * testing::random_vector(problem.nx(), engine);
    }
    program.set_center(guess);
    y = program.point_of(guess);
    program.set_point(y.data());
  }
  /// ∂L/∂y with unit multipliers for all variable bounds, and with first multipliers where every
  /// third variable has this weight.
  Eigen::VectorXd slope(double weight) {
    weights = Eigen::VectorXd::Ones(program.variables());
    for (int i = 0; i < weights.size(); i += 3) weights[i] = weight;
    const auto found = first_multipliers(program, weights, ChainFactorization::make);
    EXPECT_TRUE(found);
    rows = found.value_or(Eigen::VectorXd::Zero(program.rows()));
    return testing::lagrangian_gradient(program, 1, rows) - force(program.lower(), program.upper());
  }
  static Eigen::VectorXd force(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(lower.size());
    for (int i = 0; i < sum.size(); ++i) {
      if (lower[i] == upper[i]) continue;
      if (std::isfinite(lower[i])) sum[i] += 1;
      if (std::isfinite(upper[i])) sum[i] -= 1;
    }
    return sum;
  }

  const ShootingProblem& problem;
  Evaluator evaluator;
  Transcription program;
  Eigen::VectorXd y, weights, rows;
};

TEST(FirstMultipliers, SolveTheWeightedLeastSquaresEquations) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    First first(problem);
    const Eigen::VectorXd slope = first.slope(7);
    Eigen::VectorXd left = jacobian_times(first.program, first.weights.cwiseProduct(slope), false);
    left += First::force(first.program.row_lower(), first.program.row_upper());
    for (int row = 0; row < left.size(); ++row)
      if (first.program.row_lower()[row] < first.program.row_upper()[row])
        left[row] += first.rows[row];
    EXPECT_LE(left.lpNorm<Eigen::Infinity>(), 1e-9 * slope.lpNorm<Eigen::Infinity>()) << name;
  }
}

/// Moves x by u and integrates `rate` in c, whose terminal value costs 3 per unit.
ShootingProblem with_cost_state(const std::string& rate_of_x, const std::string& rate) {
  const auto system = expression_system({.kind = SystemKind::first_order,
                                         .states = expression_numbers({"x", "c"}),
                                         .controls = expression_columns({"u"}),
                                         .equations = {{"x", rate_of_x}, {"c", rate}}});
  Phase phase = testing::tracking_phase(system, Integrator::rk4, 4, 0.1, {{0, 0}, {0, 0}, {0}, {}},
                                        -kInfinity, kInfinity);
  auto model = std::make_shared<KnotModel>(system, Integrator::none);
  model->add_cost("end", coordinate_residual(system->manifold(), {1}),
                  {.kind = ActivationKind::linear});
  return {{1, 0},
          {std::move(phase)},
          {.name = "end", .model = model, .dt = {0}, .cost_scale = {1}, .parameters = {0, 3}}};
}

TEST(FirstMultipliers, CostateOfACostIsItsTerminalSlope) {
  const ShootingProblem problem = with_cost_state("u - x^3", "x^2 + u^2");
  First first(problem);
  const Eigen::VectorXd weights = first.program.weights_of_cost_states(1e8);
  EXPECT_EQ((weights.array() == 1e8).count(), problem.knots());
  const auto rows = first_multipliers(first.program, weights, ChainFactorization::make);
  ASSERT_TRUE(rows);
  EXPECT_EQ((rows->array().abs() - 3)
                .abs()
                .cwiseMin(1)
                .unaryExpr([](double far) { return far < 1e-6 ? 1 : 0; })
                .sum(),
            problem.knots());
}

TEST(FirstMultipliers, SharedOrLinearStatesAreNotWeighted) {
  const std::vector<std::pair<std::string, std::string>> rates = {{"u - c", "x^2 + u^2"},
                                                                  {"u - x", "x + u"}};
  for (const auto& [of_x, of_c] : rates) {
    const ShootingProblem problem = with_cost_state(of_x, of_c);
    First first(problem);
    EXPECT_EQ(first.program.weights_of_cost_states(1e8).maxCoeff(), 1) << of_c;
  }
}

TEST(FirstMultipliers, DoNotExistForNonFiniteDerivatives) {
  const ShootingProblem problem = testing::cartpole_swing_up(20);
  First first(problem);
  first.y[5] = std::numeric_limits<double>::quiet_NaN();
  first.program.set_point(first.y.data());
  EXPECT_FALSE(first_multipliers(first.program, Eigen::VectorXd::Ones(first.y.size()),
                                 ChainFactorization::make));
}

/// Minimizes ½ y² subject to y ≥ 1.
class OneBound : public NonlinearProgram {
 public:
  OneBound() {
    lower_ = Eigen::VectorXd::Ones(1);
    upper_ = Eigen::VectorXd::Constant(1, 5);
    row_lower_ = row_upper_ = Eigen::VectorXd(0);
    hessian_.add(0, 0);
  }
  void set_point(const double* y) override { y_ = y[0]; }
  double objective() override { return y_ * y_ / 2; }
  void gradient(double* out) override { out[0] = y_; }
  void constraints(double*) override {}
  void jacobian(double*) override {}
  void hessian(double weight, const double*, double* out) override { out[0] = weight; }

 private:
  double y_ = 0;
};

/// A function of the loaded OpenBLAS; null for another BLAS.
template <class Function>
Function* openblas_function(const char* name) {
  void* const library = dlopen("libopenblas.so.0", RTLD_LAZY | RTLD_NOLOAD);
  return library == nullptr ? nullptr : reinterpret_cast<Function*>(dlsym(library, name));
}

TEST(OneBlasThread, LimitsOpenBlasToOneThreadDuringSolves) {
  OneBound program;
  const Eigen::VectorXd start = Eigen::VectorXd::Constant(1, 3);
  const auto go_on = [](const InteriorPointIterate&) { return true; };
  EXPECT_EQ(minimise(program, start, {}, go_on).end, InteriorPointEnd::solved);
  const auto threads = openblas_function<int()>("openblas_get_num_threads");
  if (threads == nullptr) GTEST_SKIP() << "the system's BLAS is another one";
  openblas_function<void(int)>("openblas_set_num_threads")(2);
  const int before = threads();  // 1 if this OpenBLAS is single-threaded
  minimise(program, start, {}, [&](const InteriorPointIterate&) {
    EXPECT_EQ(threads(), 1);
    return true;
  });
  EXPECT_EQ(threads(), before);
}

}  // namespace
}  // namespace conddp
