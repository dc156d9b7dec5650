#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "problem_file/residuals/cost_residual.hpp"

namespace conddp {

/// The symmetric matrix that a file gives for the rows of a residual, called `name` in messages.
/// Reports a wrong number or length of rows, unknown names, and entries that differ from their
/// mirror images. Also reports a matrix that is not positive semidefinite, and a residual that is
/// too large for a matrix.
std::optional<Eigen::MatrixXd> resolve(const MatrixSpec& spec, const CostResidual& residual,
                                       const std::string& name, Diagnostics& out);

}  // namespace conddp
