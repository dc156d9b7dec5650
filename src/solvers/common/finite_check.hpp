#pragma once

#include <optional>
#include <string_view>

#include "ocp/evaluation/linearization.hpp"

namespace conddp {

/// Like Eigen's allFinite, but vectorised.
template <class Matrix>
bool all_finite(const Matrix& A) {
  return (A.array() * 0.0).sum() == 0;
}

/// Where a linearisation is not finite.
struct NonFinite {
  int knot;
  std::string_view quantity;  ///< "cost", "next state", "cost gradient", ...
};

/// The first knot with a quantity that is not finite, if there is one.
std::optional<NonFinite> find_non_finite(const Linearization& linearization);

}  // namespace conddp
