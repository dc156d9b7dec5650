#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "problem_file/residuals/cost_residual.hpp"

namespace conddp {

/// The symmetric matrix that a file gives to the rows of a residual, called `name` in messages.
/// Reported: rows that are too many, too few or of a wrong length, unknown names, entries that
/// differ from their mirror images, a matrix that is not positive semidefinite, and a residual that
/// is too large for one.
std::optional<Eigen::MatrixXd> resolve(const MatrixSpec& spec, const CostResidual& residual,
                                       const std::string& name, Diagnostics& out);

}  // namespace conddp
