#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace conddp {

/// How far two solutions may be apart and still mean the same.
struct ComparisonTolerances {
  double cost_relative = 1e-6;
  /// A residual may grow to this multiple of the golden one, or to the floor.
  double residual_factor = 10;
  double residual_floor = 1e-6;
  /// A column of the trajectory: atol + rtol · (largest magnitude in the golden column).
  double trajectory_absolute = 1e-4;
  double trajectory_relative = 1e-3;
  /// Rotations, by the angle between them, rad.
  double rotation = 1e-3;
};

/// What users call them: on the command line and in golden files.
struct NamedTolerance {
  const char* name;
  double ComparisonTolerances::*member;
};
inline constexpr NamedTolerance kNamedTolerances[] = {
    {"cost_relative", &ComparisonTolerances::cost_relative},
    {"residual_factor", &ComparisonTolerances::residual_factor},
    {"residual_floor", &ComparisonTolerances::residual_floor},
    {"trajectory_absolute", &ComparisonTolerances::trajectory_absolute},
    {"trajectory_relative", &ComparisonTolerances::trajectory_relative},
    {"rotation", &ComparisonTolerances::rotation},
};

/// One thing in which two solutions differ.
struct Difference {
  std::string quantity;  ///< e.g. "cost", "trajectory q/elbow at knot 12 (t = 0.12 s)"
  std::string message;   ///< both values and the tolerance
};

/// Differences of costs are relative to costs of this size at least: an optimum may be zero, and an
/// answer is not worse for the rounding that is left of it.
inline constexpr double kSmallestCostSize = 1e-3;

/// Compares two solutions (documents of the shape of solution.json) by meaning: status, cost and
/// costs by name, residuals, time grid, then every column of the trajectory; quaternions by angle.
/// Numbers of iterations are not compared. Empty if they agree. A document with a comparison_defect
/// is a difference, not an exception.
std::vector<Difference> compare_solutions(const nlohmann::json& golden,
                                          const nlohmann::json& actual,
                                          const ComparisonTolerances& tolerances = {});

/// What misses in a document, or has another shape, that comparison needs; empty if nothing.
std::optional<std::string> comparison_defect(const nlohmann::json& solution);

/// The entries of a solution that comparison needs.
inline constexpr std::string_view kComparedKeys[] = {"status", "cost", "cost_by_name", "residuals",
                                                     "trajectory"};

/// The part of a solution that comparison needs, numbers rounded to ten digits: what a golden file
/// holds.
nlohmann::json golden_part(const nlohmann::json& solution);

}  // namespace conddp
