#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace conddp {

/// Largest differences between two solutions with the same meaning.
struct ComparisonTolerances {
  double cost_relative = 1e-6;
  /// A residual may grow to this multiple of the golden one, or to the floor.
  double residual_factor = 10;
  double residual_floor = 1e-6;
  /// Tolerance of a trajectory column: atol + rtol · (largest magnitude in the golden column).
  double trajectory_absolute = 1e-4;
  double trajectory_relative = 1e-3;
  /// Angle between rotations, rad.
  double rotation = 1e-3;
};

/// Name of a tolerance on the command line and in golden files.
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

/// A difference between two solutions.
struct Difference {
  std::string quantity;  ///< e.g. "cost", "trajectory q/elbow at knot 12 (t = 0.12 s)"
  std::string message;   ///< both values and the tolerance
};

/// Smallest reference for relative cost differences. An optimum may be zero, and the rounding left
/// of it does not make an answer worse.
inline constexpr double kSmallestCostSize = 1e-3;

/// Compares two solutions (documents in the form of solution.json) by meaning: status, cost and
/// costs by name, residuals, time grid, then every column of the trajectory; quaternions by angle.
/// Iteration counts are not compared. Returns an empty list if the solutions agree. A document with
/// a comparison_defect yields a difference, not an exception.
std::vector<Difference> compare_solutions(const nlohmann::json& golden,
                                          const nlohmann::json& actual,
                                          const ComparisonTolerances& tolerances = {});

/// Describes a missing or malformed entry that comparison needs; nullopt for a valid document.
std::optional<std::string> comparison_defect(const nlohmann::json& solution);

/// Entries of a solution that comparison needs.
inline constexpr std::string_view kComparedKeys[] = {"status", "cost", "cost_by_name", "residuals",
                                                     "trajectory"};

/// The part of a solution that comparison needs, as stored in golden files, with numbers rounded to
/// ten digits.
nlohmann::json golden_part(const nlohmann::json& solution);

}  // namespace conddp
