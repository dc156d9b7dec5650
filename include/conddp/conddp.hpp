// All of the library but its files: robots, systems, residuals, problems, solvers. docs/library.md
// is its manual. These headers change only with the minor version; what lies in `detail` is
// internal.
#pragma once

#include "conddp/mpc.hpp"
#include "conddp/problem.hpp"
#include "conddp/residual.hpp"
#include "conddp/robot.hpp"
#include "conddp/solver.hpp"
#include "conddp/system.hpp"
#include "conddp_version.hpp"
