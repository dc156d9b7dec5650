#pragma once

#include <optional>
#include <string_view>

#include "ocp/evaluation/linearization.hpp"

namespace conddp {

/// Vectorized equivalent of Eigen's allFinite.
template <class Matrix>
bool all_finite(const Matrix& A) {
  return (A.array() * 0.0).sum() == 0;
}

/// Location of the first non-finite quantity of a linearization.
struct NonFinite {
  int knot;
  std::string_view quantity;  ///< "cost", "next state", "cost gradient", ...
};

/// First knot with a non-finite quantity, if any.
std::optional<NonFinite> find_non_finite(const Linearization& linearization);

}  // namespace conddp
