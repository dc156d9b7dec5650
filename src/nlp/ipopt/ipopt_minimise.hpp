#pragma once

#include <functional>

#include <Eigen/Core>

#include "nlp/interior_point.hpp"
#include "nlp/nonlinear_program.hpp"

namespace conddp {

/// `minimise` of interior_point.hpp, with Ipopt linked.
InteriorPointAnswer ipopt_minimise(NonlinearProgram& program, const Eigen::VectorXd& start,
                                   const InteriorPointSettings& settings,
                                   const std::function<bool(const InteriorPointIterate&)>&);

}  // namespace conddp
