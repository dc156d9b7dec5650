#include "problem_file/assemble/homotopy.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "problem_file/read/read_problem.hpp"

namespace conddp {
namespace {

/// Share at which interpolation between different integers does not yield an integer.
constexpr double kGenericShare = 0.38196601125010515;

/// True if each bound is finite in both or in neither, and the same rows are equalities.
bool same_bounds(const NodeConstraint& a, const NodeConstraint& b) {
  if (!a.term->has_bounds() || !b.term->has_bounds()) return true;
  for (int i = 0; i < a.term->rows; ++i)
    if (std::isfinite(a.lower[i]) != std::isfinite(b.lower[i]) ||
        std::isfinite(a.upper[i]) != std::isfinite(b.upper[i]) ||
        (a.lower[i] == a.upper[i]) != (b.lower[i] == b.upper[i]))
      return false;
  return true;
}

bool are_alike(const NodeConstraint& a, const NodeConstraint& b) {
  return a.node == b.node && a.row == b.row && a.term->name == b.term->name &&
         a.term->kind == b.term->kind && same_bounds(a, b);
}

bool same_constraints(const ShootingProblem& a, const ShootingProblem& b) {
  return a.constraint_rows() == b.constraint_rows() &&
         std::equal(a.constraints().begin(), a.constraints().end(), b.constraints().begin(),
                    b.constraints().end(), are_alike);
}

/// Difference between the shapes of two problems; empty if they agree.
std::string difference(const ShootingProblem& a, const ShootingProblem& b) {
  if (a.knots() != b.knots()) return fmt::format("knots, {} and {}", a.knots(), b.knots());
  if (a.nx() != b.nx() || a.ndx() != b.ndx())
    return fmt::format("states, {} and {}", a.nx(), b.nx());
  for (int k = 0; k < a.knots(); ++k)
    if (a.nu(k) != b.nu(k))
      return fmt::format("controls of knot {}, {} and {}", k, a.nu(k), b.nu(k));
  if (a.has_control_bounds() != b.has_control_bounds()) return "bounds on the control";
  return same_constraints(a, b) ? "" : "constraints";
}

/// Reports why an intermediate problem cannot be built, at the first key of the homotopy.
void report(const Diagnostics& attempt, const ProblemSpec& spec, double share, Diagnostics& out) {
  for (const Diagnostic& d : attempt.list()) {
    if (d.severity != Severity::kError) continue;
    out.error(
        spec.solver.homotopy.front().key.place,
        fmt::format("the problem at {:.3g} of the homotopy cannot be built: {}", share, d.message),
        d.hint);
    return;
  }
}

}  // namespace

std::shared_ptr<const BuiltProblem> Homotopy::station(double share, Diagnostics& out) const {
  auto spec =
      read_problem_text(end_->text, end_->file, end_->settings, out, {.homotopy_share = share});
  if (!spec) return nullptr;
  spec->guess = {};
  spec->solver = end_->solver;
  spec->solver.homotopy.clear();
  spec->perturbation = end_->perturbation;
  auto built = build_without_homotopy(*std::move(spec), options_, out);
  return built ? std::make_shared<const BuiltProblem>(*std::move(built)) : nullptr;
}

std::shared_ptr<const Homotopy> Homotopy::build(const BuiltProblem& end,
                                                const BuildOptions& options, Diagnostics& out) {
  const ProblemSpec& spec = *end.problem_spec;
  auto homotopy = std::make_shared<Homotopy>();
  homotopy->end_ = end.problem_spec;
  homotopy->options_ = options;
  homotopy->options_.plant = nullptr;  // the homotopy may change values of the robots
  for (const double share : {kGenericShare, 0.0}) {
    Diagnostics attempt;
    homotopy->start_ = homotopy->station(share, attempt);
    if (!homotopy->start_) {
      report(attempt, spec, share, out);
      return nullptr;
    }
    const std::string differs = difference(*homotopy->start_->problem, *end.problem);
    if (differs.empty()) continue;
    out.error(spec.solver.homotopy.front().key.place,
              fmt::format("a homotopy cannot change the shape of the problem: between {:.3g} of "
                          "its way and its end these differ: {}",
                          share, differs),
              "move numbers alone: weights, limits, friction, masses, lengths, times");
    return nullptr;
  }
  return homotopy;
}

ProblemPath homotopy_path(const BuiltProblem& built) {
  return built.homotopy ? Homotopy::path(built.homotopy) : nullptr;
}

ProblemPath Homotopy::path(std::shared_ptr<const Homotopy> homotopy) {
  return [homotopy = std::move(homotopy)](double share) -> std::shared_ptr<const ShootingProblem> {
    Diagnostics unused;
    const auto station = share == 0 ? homotopy->start_ : homotopy->station(share, unused);
    return station ? station->problem : nullptr;
  };
}

}  // namespace conddp
