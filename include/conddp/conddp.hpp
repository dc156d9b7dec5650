// The stable door of the library: what this header includes is documented in docs/library.md and
// changes only with the minor version. All other headers are internal.
#pragma once

#include "conddp_version.hpp"
#include "ocp/problem/problem.hpp"
#include "ocp/residuals/residuals.hpp"
#include "robot/urdf/urdf.hpp"
#include "solvers/strategies/registry.hpp"
#include "systems/catalogue.hpp"
#include "systems/closed_form.hpp"
#include "systems/multibody/multibody.hpp"
