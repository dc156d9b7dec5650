#include "analysis/certificate/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "analysis/certificate/feasibility.hpp"
#include "analysis/certificate/gains_check.hpp"
#include "analysis/certificate/lagrangian_gradient.hpp"
#include "analysis/derivatives/node_models.hpp"
#include "ocp/problem/cost_scale.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/common/status.hpp"

namespace conddp {
namespace {

/// Allowed difference between two evaluations of a quantity, relative to the size of its terms. It
/// covers a different order of rounding, amplified by badly conditioned contacts.
constexpr double kRounding = 1e-10;
/// The same for a gradient entry, relative to its own terms and to the largest terms of its knot:
/// intermediate terms that cancel leave rounding.
constexpr double kOwnRounding = 1e-11;
constexpr double kKnotRounding = 1e-12;

const std::string kDiverged(to_string(SolveStatus::diverged)),
    kInfeasible(to_string(SolveStatus::infeasible));

/// Effect of rounding the answer's own numbers on the figures. It matters if they are so badly
/// conditioned (contacts far from where they hold, extreme speeds) that the tolerances above do not
/// cover it.
struct Noise {
  double cost = 0, gap = 0, stationarity = 0, state = 0, constraint = 0;
  std::optional<DisplacedModel> displaced;  ///< used to check the gains
};

/// Largest finite change of an entry.
double largest_change(const Eigen::Ref<const Eigen::MatrixXd>& a,
                      const Eigen::Ref<const Eigen::MatrixXd>& b) {
  double largest = 0;
  for (Eigen::Index j = 0; j < a.cols(); ++j)
    for (Eigen::Index i = 0; i < a.rows(); ++i)
      if (const double change = std::abs(a(i, j) - b(i, j)); std::isfinite(change))
        largest = std::max(largest, change);
  return largest;
}

class Judge {
 public:
  /// The costs of the problem and the claims are `scale` times those of the file; figures are in
  /// the unit of the file. `nodes` are the values at the claimed trajectory.
  Judge(const ShootingProblem& problem, const SolutionClaims& claims, const NodeValues& nodes,
        double scale)
      : problem_(problem), claims_(claims), nodes_(nodes), scale_(scale) {
    evaluate();
  }

  /// Rounding may change a figure by this multiple of its change under moves of 10⁻¹³.
  static constexpr double kRoundingMargin = 100;

  /// Perturbs all states and controls at random by at most 10⁻¹³ of themselves.
  static void displace(Trajectory& trajectory) {
    constexpr double kMove = 1e-13;
    std::mt19937_64 engine(2);
    const auto move = [&](double& number) {
      number *= 1 + kMove * (2 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1);
    };
    for (int k = 0; k <= trajectory.knots(); ++k) {
      for (double& number : trajectory.x(k)) move(number);
      if (k == trajectory.knots()) break;
      for (double& number : trajectory.u(k)) move(number);
    }
  }

  /// Rounding is measured only if a claim does not hold without it.
  Certificate run() {
    check_claims();
    if (!certificate_.holds()) {
      noise_ = measure_noise();
      certificate_.checks.clear();
      check_claims();
    }
    for (const OptimalityFigure& figure : kOptimalityFigures)
      certificate_.optimality.*figure.value /= scale_;
    return std::move(certificate_);
  }

 private:
  void check_claims() {
    check_times();
    check_initial_state();
    check_quaternions();
    check_costs();
    figure("gap", claims_.gap, gap_, state_rounding());
    check_bounds();
    check_gradient();
    check_status();
  }

  /// Changes of the figures when all states and controls move so little that only rounding shows.
  /// The margin allows for evaluations of thousands of operations, which accumulate more than one
  /// rounding of their arguments.
  Noise measure_noise() const {
    constexpr double kMargin = kRoundingMargin;
    SolutionClaims moved = claims_;
    displace(moved.trajectory);
    const NodeValues moved_nodes(problem_, moved.trajectory);
    Judge there(problem_, moved, moved_nodes, 1);
    const LagrangianGradient a = gradient(), b = there.gradient();
    Noise noise;
    const double cost = kMargin * std::abs(cost_ - there.cost_);
    noise.cost = std::isfinite(cost) ? cost : 0;
    noise.gap = kMargin * largest_change(gaps_, there.gaps_);
    for (std::size_t k = 0; k < a.control.size(); ++k)
      noise.stationarity =
          std::max(noise.stationarity, kMargin * largest_change(a.control[k], b.control[k]));
    noise.state = kMargin * largest_change(a.state, b.state);
    noise.constraint = kMargin * largest_change(nodes_.constraint(), moved_nodes.constraint());
    noise.displaced = {std::move(moved.trajectory), std::move(there.models_.derivatives), kMargin};
    return noise;
  }

  void add(Check check) { certificate_.checks.push_back(std::move(check)); }

  const std::string& tangent(int i) const {
    static const std::string none;
    return i >= 0 && i < static_cast<int>(claims_.tangent_names.size()) ? claims_.tangent_names[i]
                                                                        : none;
  }

  /// A diverged answer may leave figures open (NaN); others may not.
  bool agree(double claimed, double found, double tolerance) const {
    if (std::isnan(claimed)) return claims_.status == kDiverged;
    return std::abs(claimed - found) <= tolerance;
  }

  void figure(std::string name, double claimed, double found, double tolerance,
              std::string place = {}) {
    add({std::move(name),
         agree(claimed, found, tolerance),
         claimed,
         found,
         tolerance,
         std::move(place),
         {}});
  }
  void figure(std::string name, double claimed, const Worst& found, double tolerance) {
    figure(std::move(name), claimed, found.value, tolerance,
           found.knot < 0 ? "" : place_text(problem_, found.knot, tangent(found.entry)));
  }

  /// Adds a figure in the unit of the costs.
  void cost_figure(std::string name, double claimed, double found, double tolerance,
                   std::string place = {}) {
    figure(std::move(name), claimed, found, tolerance, std::move(place));
    Check& check = certificate_.checks.back();
    for (double Check::*number : {&Check::claimed, &Check::found, &Check::tolerance})
      check.*number /= scale_;
  }

  void check_times() {
    const std::vector<double> times = problem_.times(claims_.trajectory);
    Worst worst;
    for (int k = 0; k <= problem_.knots(); ++k)
      worst.meet(std::abs(claims_.times[k] - times[k]), 0, k, -1);
    const double tolerance = 1e-12 * std::max(1.0, times.back());
    const bool holds = worst.value <= tolerance;
    const int k = std::max(worst.knot, 0);
    add({"times", holds, claims_.times[holds ? problem_.knots() : k],
         times[holds ? problem_.knots() : k], tolerance, holds ? "" : place_text(problem_, k, ""),
         ""});
  }

  void check_initial_state() {
    const int ndx = problem_.ndx();
    Eigen::VectorXd off(ndx);
    problem_.manifold().difference(problem_.initial_state().data(), claims_.trajectory.x(0).data(),
                                   off.data());
    Worst worst;
    for (int i = 0; i < ndx; ++i) worst.meet(std::abs(off[i]), 0, 0, i);
    const double size = claims_.trajectory.x(0).lpNorm<Eigen::Infinity>();
    figure("initial state", 0, worst, 1e-12 * std::max(1.0, size));
  }

  void check_quaternions() {
    if (problem_.manifold().curved().empty()) return;
    Worst worst;
    for (int k = 0; k <= problem_.knots(); ++k)
      for (const auto& segment : problem_.manifold().curved()) {
        const int first = segment.x + (segment.part == StateManifold::Part::se3 ? 3 : 0);
        const double length = claims_.trajectory.x(k).segment<4>(first).norm();
        worst.meet(std::abs(length - 1), 0, k, -1);
      }
    figure("unit quaternions", 0, worst, 1e-9);
  }

  /// Evaluates every knot from its own state.
  void evaluate() {
    const int N = problem_.knots(), ndx = problem_.ndx();
    gaps_.resize(ndx, N);
    for (int k = 0; k <= N; ++k) {
      add_costs(k, k == N ? "terminal/" : "");
      if (k == N) break;
      const auto x = claims_.trajectory.x(k);
      const auto next = nodes_.next().col(k);
      problem_.manifold().difference(claims_.trajectory.x(k + 1).data(), next.data(),
                                     gaps_.col(k).data());
      const double size = next.cwiseAbs().sum();
      for (int i = 0; i < ndx; ++i) gap_.meet(std::abs(gaps_(i, k)), size, k, i);
      largest_state_ =
          std::max({largest_state_, x.lpNorm<Eigen::Infinity>(), size / problem_.nx()});
    }
    models_ = node_models(problem_, claims_.trajectory, gaps_);
  }

  void add_costs(int node, const std::string& prefix) {
    const KnotView& view = problem_.knot(node);
    const std::span<const double> costs = nodes_.term_costs(node);
    const std::span<const double> soft_costs = nodes_.soft_costs(node);
    for (std::size_t t = 0; t < view.model->costs().size(); ++t)
      add_cost(prefix + view.model->costs()[t].name, costs[t]);
    const std::vector<ConstraintTerm>& constraints = view.model->constraints();
    for (std::size_t t = 0; t < constraints.size(); ++t)
      if (constraints[t].softness != Softness::hard)
        add_cost(prefix + constraints[t].name, soft_costs[t]);
  }

  void add_cost(const std::string& name, double cost) {
    cost_ += cost;
    cost_size_ += std::abs(cost);
    for (auto& [known, sum] : costs_)
      if (known == name) {
        sum += cost;
        return;
      }
    costs_.emplace_back(name, cost);
  }

  double state_rounding() const { return 1e-11 * std::max(1.0, largest_state_) + noise_.gap; }

  void check_costs() {
    const double tolerance = kRounding * std::max(1e-6, cost_size_) + noise_.cost;
    cost_figure("cost", claims_.cost, cost_, tolerance);
    std::map<std::string, double> claimed(claims_.cost_by_name.begin(), claims_.cost_by_name.end());
    for (const auto& [name, found] : costs_) {
      const auto claim = claimed.find(name);
      if (claim == claimed.end()) {
        add({"cost " + name, false, Check::kNone, found / scale_, Check::kNone, "",
             "is not in the answer"});
        continue;
      }
      cost_figure("cost " + name, claim->second, found, tolerance);
      claimed.erase(claim);
    }
    for (const auto& [name, value] : claimed)
      add({"cost " + name, false, value / scale_, Check::kNone, Check::kNone, "",
           "the problem has no such cost"});
  }

  void check_bounds() {
    const auto [violation, product, negative] =
        measure_feasibility(problem_, claims_, nodes_.constraint());
    const auto at = [&](const Worst& w) {
      if (w.knot < 0) return std::string();
      return place_text(
          problem_, w.knot,
          w.entry >= 0 ? control_name(problem_, w.knot, w.entry) : constraint_name(w));
    };
    found_constraint_ = violation.value;
    // Constraint values near zero may come from large terms, which their size does not show.
    const bool constrained = !problem_.constraints().empty();
    const double tolerance = constrained ? kRounding : 1e-14;
    const double value = constrained ? 1 : 0;
    const double multiplier = constrained ? claims_.multipliers.lpNorm<Eigen::Infinity>() : 0;
    figure("constraint violation", claims_.constraint, violation.value,
           tolerance * std::max(value, violation.size) + noise_.constraint, at(violation));
    figure("complementarity", claims_.complementarity, product.value,
           tolerance * std::max(multiplier, product.size) + noise_.constraint * multiplier,
           at(product));
    found_complementarity_ = product.value;
    if (negative.knot >= 0)
      add({"signs of multipliers", false, Check::kNone, negative.value / scale_, 0, at(negative),
           "a multiplier has the wrong sign"});
  }

  std::string constraint_name(const Worst& w) const {
    const int place = constraint_of(w);
    return place < 0 ? "" : "constraint '" + problem_.constraints()[place].term->name + "'";
  }

  /// Gradient of the Lagrangian at the answer's own co-states.
  LagrangianGradient gradient() const {
    return lagrangian_gradient(problem_, models_.derivatives, claims_.costates,
                               claims_.multipliers);
  }

  void check_gradient() {
    if (claims_.status == kDiverged && !(claims_.stationarity <= kLargestStationarity)) return;
    const LagrangianGradient found = gradient();
    Worst stationarity;
    stationarity_rounding_ = kOwnRounding;
    for (int k = 0; k < problem_.knots(); ++k)
      for (int i = 0; i < problem_.nu(k); ++i) {
        const double zl = claims_.lower_multipliers[k][i], zu = claims_.upper_multipliers[k][i];
        const double size = found.control_size[k][i] + std::abs(zl) + std::abs(zu);
        stationarity.meet(std::abs(found.control[k][i] - zl + zu), size, k, i);
        stationarity_rounding_ =
            std::max(stationarity_rounding_,
                     kOwnRounding * size + kKnotRounding * found.control_size[k].maxCoeff());
      }
    stationarity_rounding_ += noise_.stationarity;
    found_stationarity_ = stationarity.value;
    cost_figure("stationarity", claims_.stationarity, stationarity.value, stationarity_rounding_,
                stationarity.knot < 0
                    ? ""
                    : place_text(problem_, stationarity.knot,
                                 control_name(problem_, stationarity.knot, stationarity.entry)));
    check_costates(found);
    const RiccatiPolicy policy =
        riccati_policy(problem_, claims_.trajectory, models_.derivatives, models_.hessians);
    measure_optimality(policy);
    for (Check& check : check_gains(problem_, claims_, models_.derivatives, models_.hessians, gaps_,
                                    noise_.displaced ? &*noise_.displaced : nullptr))
      add(std::move(check));
  }

  /// Computes stationarity without the answer's co-states and gains.
  void measure_optimality(const RiccatiPolicy& policy) {
    const auto pass = [&](const std::vector<Eigen::MatrixXd>& gains) {
      return adjoint_pass(problem_, models_.derivatives, claims_.multipliers, gains);
    };
    const auto norm = [&](const AdjointPass& found) {
      return project(problem_, claims_.trajectory, found.control);
    };
    const AdjointPass along = pass(policy.K), plain = pass({});
    const ProjectedGradient gradient = norm(along);
    certificate_.optimality = {gradient.stationarity, along.rounding, norm(plain).stationarity,
                               plain.rounding, policy.decrease(along.control)};
    // The smaller one counts: rounding may blur either of them.
    own_stationarity_ =
        std::min(certificate_.optimality.stationarity, certificate_.optimality.reduced_gradient);
    const auto distance = [&](const AdjointPass& found) {
      return (found.costates - claims_.costates).lpNorm<Eigen::Infinity>() /
             std::max(1.0, found.costates.lpNorm<Eigen::Infinity>());
    };
    const double error = distance(along), plain_error = distance(plain);
    costate_error_ = std::fmin(error, plain_error);
    // The pass with the closer co-states counts: the policy's model may be singular, and motions
    // without it unstable.
    if (claims_.converged) measure_curvature(plain_error < error ? plain : along);
    if (gradient.knot >= 0)
      own_place_ = " at " + place_text(problem_, gradient.knot,
                                       control_name(problem_, gradient.knot, gradient.entry));
  }

  /// Cost change that counts as nothing. If all costs are zero, only multipliers remain, and their
  /// tolerance stands for the change by a unit move.
  double negligible_cost() const {
    double least = least_cost(problem_);
    if (cost_size_ == 0) least = std::max(least, claims_.tolerances.stationarity);
    return std::max(kMostGain * least, kNothing * cost_size_);
  }

  void measure_curvature(const AdjointPass& pass) {
    if (!certificate_.second_order) {
      const JudgedPoint point{problem_,
                              claims_.trajectory,
                              gaps_,
                              models_.derivatives,
                              models_.hessians,
                              nodes_.constraint(),
                              claims_.multipliers,
                              pass.costates,
                              pass.control,
                              cost_size_,
                              negligible_cost()};
      certificate_.second_order = second_order(point);
      certificate_.second_order->scale(1 / scale_);
    }
    SecondOrder& found = *certificate_.second_order;
    if (found.hidden_share() > kMostLeft) {
      found.curvature = Curvature::undecided;
      certificate_.curvature =
          fmt::format("rounding hides whether a Newton step would gain {:.2g} of its cost",
                      found.hidden_share());
      return;
    }
    if (found.kink) {
      certificate_.curvature =
          fmt::format("a kink of {} at {}, beyond which the cost may fall", found.kink->part,
                      place_text(problem_, found.kink->node, ""));
      return;
    }
    if (found.curvature == Curvature::positive) return;
    const std::string place = place_text(problem_, std::max(found.knot, 0), "");
    certificate_.curvature =
        found.curvature == Curvature::negative
            ? fmt::format("a motion that begins at {} lowers the cost by about {:.2g}", place,
                          -found.bend)
            : fmt::format("rounding leaves no curvature at {}{}", place, blame(found));
  }

  /// Names the equation that leaves a second-order model undecided, if there is one.
  static std::string blame(const SecondOrder& found) {
    if (found.doubtful.empty()) return {};
    return fmt::format(
        ", because of '{}': other constraints, contacts or loops imply some of its rows, or hardly "
        "any control moves them",
        found.doubtful);
  }

  /// Checks the co-state equation: the claimed gradient ∇_x of the Lagrangian.
  void check_costates(const LagrangianGradient& found) {
    const Eigen::MatrixXd& claimed = claims_.state_gradient;
    const Eigen::MatrixXd size = found.state_size + claimed.cwiseAbs();
    Worst excess;
    for (Eigen::Index k = 0; k < claimed.cols(); ++k)
      for (Eigen::Index i = 0; i < claimed.rows(); ++i) {
        const double tolerance = kOwnRounding * std::max(1.0, size(i, k)) +
                                 kKnotRounding * size.col(k).maxCoeff() + noise_.state;
        excess.meet(std::abs(found.state(i, k) - claimed(i, k)) / tolerance, tolerance,
                    static_cast<int>(k), static_cast<int>(i));
      }
    if (excess.value <= 1) {
      add({"co-states"});
      return;
    }
    const int k = std::max(excess.knot, 0), i = std::max(excess.entry, 0);
    add({"co-states", false, claimed(i, k) / scale_, found.state(i, k) / scale_,
         excess.size / scale_, place_text(problem_, k, tangent(i)), ""});
  }

  /// True if all residuals claimed by the answer are below their tolerances.
  bool claims_convergence() const {
    const auto& t = claims_.tolerances;
    return claims_.stationarity <= t.stationarity && claims_.gap <= t.gap &&
           claims_.constraint <= t.constraint && claims_.complementarity <= t.complementarity;
  }

  /// True if much of the cost may be left to gain without constraints, or if the model lacks a
  /// minimum and cannot tell.
  bool much_may_be_left() const {
    const double share =
        certificate_.optimality.expected_decrease / std::max(std::abs(cost_), least_cost(problem_));
    return problem_.constraints().empty() && !(share <= kMostGain);
  }

  /// An answer has converged if all residuals are below tolerance at once, both the claimed ones
  /// and those found without its co-states, and little is left to gain. An answer with small
  /// residuals may have another status if much may be left to gain.
  void check_status() {
    if (claims_.converged != claims_convergence() && (claims_.converged || !much_may_be_left()))
      return judge_status(
          claims_.converged
              ? "'converged', but a claimed residual is above its tolerance"
              : fmt::format("'{}', but all claimed residuals are under their tolerances",
                            claims_.status));
    if (claims_.status == to_string(SolveStatus::cost_settled)) return check_settled();
    if (claims_.converged) return check_converged();
    judge_status("");
    if (claims_.status == kInfeasible) check_least_violation();
  }

  /// Adds the status check, which holds if `wrong` is empty.
  void judge_status(std::string wrong) {
    add({.name = kStatusCheck, .holds = wrong.empty(), .message = std::move(wrong)});
  }

  void check_converged() {
    const auto& t = claims_.tolerances;
    std::string above;
    bool feasible = true;
    const auto need = [&](const char* what, double found, double limit) {
      if (found <= limit) return true;
      above += fmt::format("{}{} is {:.2g}, tolerance {:.2g}", above.empty() ? "" : "; ", what,
                           found, limit);
      return false;
    };
    need("stationarity", found_stationarity_, t.stationarity + stationarity_rounding_);
    need(("the reduced gradient" + own_place_).c_str(), own_stationarity_,
         kPolicyMargin * t.stationarity);
    feasible &= need("gap", gap_.value, t.gap + state_rounding());
    feasible &= need("constraint violation", found_constraint_, t.constraint);
    need("complementarity", found_complementarity_, t.complementarity);
    need("the relative distance of the co-states from those with other gains and without gains",
         costate_error_, kCostateMargin * t.stationarity);
    if (certificate_.second_order &&
        !need("the share of the cost that a Newton step would gain or repair",
              certificate_.second_order->share(), kMostLeft))
      above += blame(*certificate_.second_order);
    certificate_.optimality_in_doubt = feasible && !above.empty();
    const std::string costs = scale_ == 1 ? "" : fmt::format("with costs times {:.3g}, ", scale_);
    judge_status(above.empty() ? "" : "'converged', but " + costs + above);
  }

  /// A settled cost requires a motion that satisfies dynamics and constraints.
  void check_settled() {
    const auto& t = claims_.tolerances;
    const bool feasible =
        std::max(claims_.gap, gap_.value - state_rounding()) <= t.gap &&
        std::max(claims_.constraint, found_constraint_) <= t.constraint &&
        std::max(claims_.complementarity, found_complementarity_) <= t.complementarity;
    std::string wrong;
    if (!feasible) wrong = "a gap, a violation or the complementarity is above its tolerance";
    if (t.cost_decrease == 0) wrong = "tolerances.cost_decrease is 0";
    judge_status(wrong.empty() ? "" : "'cost_settled', but " + wrong);
  }

  /// An infeasible answer must follow from its controls, and no move of the controls may lower its
  /// violation.
  void check_least_violation() {
    const double share =
        attainable_share(problem_, claims_.trajectory, models_.derivatives, nodes_.constraint());
    const SecondOrder model = violation_model(problem_, claims_.trajectory, gaps_);
    std::string wrong;
    if (gap_.value > claims_.tolerances.gap + state_rounding())
      wrong = "the states do not follow from the controls";
    else if (!(share <= kLeastViolationShare))
      wrong = fmt::format(
          "moves of the controls lower the violation by {:.2g} of it, to first order", share);
    else if (model.curvature == Curvature::negative)
      wrong = "a neighboring motion has a smaller violation";
    else if (!(model.share() <= kLeastViolationShare))
      wrong = fmt::format("a Newton step takes {:.2g} of the squared violation", model.share());
    add({"least violation", wrong.empty(), Check::kNone, share, kLeastViolationShare, "",
         wrong.empty() ? "" : "'infeasible', but " + wrong});
  }

  /// Above this, rounding leaves nothing of the co-states of a diverged answer.
  static constexpr double kLargestStationarity = 1e16;
  /// Allowed ratio of stationarities along different policies; the answer's belongs to its last
  /// sweep.
  static constexpr double kPolicyMargin = 10;
  /// Allowed distance between co-states along different policies, relative to the largest one and
  /// to the stationarity tolerance. The remaining gradient reaches them through gains that add up
  /// over the horizon.
  static constexpr double kCostateMargin = 1000;
  /// Share of the cost that may be left to gain, ten times as much as solvers leave.
  static constexpr double kMostGain = 1e-3;
  /// Share of the cost that counts as nothing, however little of it a motion changes.
  static constexpr double kNothing = 1e-9;
  /// Share of the cost that a converged answer may leave, by the second-order model.
  static constexpr double kMostLeft = 1e-5;

  const ShootingProblem& problem_;
  const SolutionClaims& claims_;
  const NodeValues& nodes_;
  const double scale_;
  Noise noise_;
  Certificate certificate_;
  std::vector<std::pair<std::string, double>> costs_;
  double cost_ = 0, cost_size_ = 0;
  Eigen::MatrixXd gaps_;
  NodeModels models_;
  Worst gap_;
  double largest_state_ = 0, own_stationarity_ = 0;
  double costate_error_ = 0;
  std::string own_place_;
  double found_constraint_ = 0, found_complementarity_ = 0;
  double found_stationarity_ = 0, stationarity_rounding_ = 0;
};

/// The claims for the problem with its costs multiplied by `scale`.
SolutionClaims scaled(const SolutionClaims& claims, double scale) {
  SolutionClaims own = claims;
  for (double SolutionClaims::*number :
       {&SolutionClaims::cost, &SolutionClaims::stationarity, &SolutionClaims::gain_regularization})
    own.*number *= scale;
  for (auto& [name, cost] : own.cost_by_name) cost *= scale;
  own.costates *= scale;
  own.state_gradient *= scale;
  own.multipliers *= scale;
  for (auto* list : {&own.lower_multipliers, &own.upper_multipliers})
    for (Eigen::VectorXd& multipliers : *list) multipliers *= scale;
  return own;
}

}  // namespace

bool Certificate::holds() const { return failures() == 0; }

int Certificate::failures() const {
  return static_cast<int>(
      std::count_if(checks.begin(), checks.end(), [](const Check& c) { return !c.holds; }));
}

Verdict Certificate::verdict() const {
  if (!holds()) return Verdict::contradicted;
  if (!second_order) return Verdict::consistent;
  switch (second_order->curvature) {
    case Curvature::positive:
      return Verdict::local_minimum;
    case Curvature::negative:
      return Verdict::not_a_minimum;
    case Curvature::undecided:
      break;
  }
  return Verdict::stationary;
}

std::string_view to_string(Verdict verdict) {
  constexpr std::string_view kNames[] = {"contradicted", "consistent", "local_minimum",
                                         "stationary", "not_a_minimum"};
  return kNames[static_cast<int>(verdict)];
}

bool Certificate::doubts_optimality_alone() const {
  return !holds() && std::ranges::all_of(checks, [this](const Check& c) {
    return c.holds || c.name == kFeedforwardCheck ||
           (c.name == kStatusCheck && optimality_in_doubt);
  });
}

bool Certificate::computable() const {
  return std::none_of(checks.begin(), checks.end(), [](const Check& c) {
    return !c.holds && !std::isnan(c.tolerance) && !std::isfinite(c.found);
  });
}

Certificate certify(const ShootingProblem& problem, const SolutionClaims& claims) {
  return certify(problem, claims, NodeValues(problem, claims.trajectory));
}

Certificate certify(const ShootingProblem& problem, const SolutionClaims& claims,
                    const NodeValues& values) {
  const double scale = cost_scale(problem);
  if (scale == 1) return Judge(problem, claims, values, 1).run();
  const ShootingProblem own = scale_costs(problem, scale);
  const SolutionClaims own_claims = scaled(claims, scale);
  return Judge(own, own_claims, NodeValues(own, claims.trajectory), scale).run();
}

double constraint_rounding(const ShootingProblem& problem, const Trajectory& trajectory,
                           const NodeValues& values) {
  Trajectory moved = trajectory;
  Judge::displace(moved);
  const Eigen::ArrayXd size = values.constraint().array().abs().max(1);
  const Eigen::ArrayXd change =
      (values.constraint() - NodeValues(problem, moved).constraint()).array().abs() / size;
  return Judge::kRoundingMargin *
         largest_change(change.matrix(), Eigen::VectorXd::Zero(change.size()));
}

}  // namespace conddp
