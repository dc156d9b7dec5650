#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "solvers/linalg/lane_matrix.hpp"

namespace conddp {

/// State of an entry of a box QP's solution.
enum class BoundState : std::int8_t { at_lower = -1, free = 0, at_upper = 1 };

/// Minimizes ½ xᵀ H x + gᵀ x subject to lower ≤ x ≤ upper by projected Newton with free and clamped
/// blocks (Bertsekas 1982; Tassa, Mansard, Todorov 2014, algorithm 1). Bounds may be infinite and
/// may coincide. Does not allocate after construction.
class BoxQp {
 public:
  enum class Status {
    solved,                 ///< up to rounding; entries at a bound equal it exactly
    not_positive_definite,  ///< a free block of H in the iteration is not positive definite
    iteration_limit,        ///< feasible and no worse than the start, but not optimal
  };

  explicit BoxQp(int max_size);

  /// `active` (one entry per entry of x) gives the start. Held entries start at their bound and
  /// stay there in the first step; free entries start from 0 or the nearest allowed value. On
  /// return it gives the states of the solution.
  Status solve(const Eigen::Ref<const Eigen::MatrixXd>& H,
               const Eigen::Ref<const Eigen::VectorXd>& g,
               const Eigen::Ref<const Eigen::VectorXd>& lower,
               const Eigen::Ref<const Eigen::VectorXd>& upper, std::span<BoundState> active);

  auto x() const { return x_.head(size_); }
  /// Free entries at the solution, in ascending order.
  std::span<const int> free() const {
    return {free_.data(), static_cast<std::size_t>(free_count_)};
  }
  /// Cholesky factor L of the free block of H at the solution.
  LaneBlock free_factor() { return factor_.block(free_count_, 0, free_count_); }
  int iterations() const { return iterations_; }

 private:
  /// Descent of a step: none beyond rounding, by the Newton step of the free entries, or by a
  /// shorter or projected step.
  enum class Descent { none, newton, shorter };
  void start(const Eigen::Ref<const Eigen::VectorXd>& lower,
             const Eigen::Ref<const Eigen::VectorXd>& upper, std::span<const BoundState> active);
  bool update_free_set(const Eigen::Ref<const Eigen::VectorXd>& lower,
                       const Eigen::Ref<const Eigen::VectorXd>& upper, bool trust,
                       std::span<BoundState> active);
  bool factor_free_block(const Eigen::Ref<const Eigen::MatrixXd>& H);
  bool free_gradient_vanishes(double rounding) const;
  void find_direction();
  /// First bound that a step along the direction meets in an entry that descends towards it.
  struct Block {
    int entry = -1;
    double length = 2;  ///< beyond all steps: no bound
    double bound = 0;
  };
  Block first_block(const Eigen::Ref<const Eigen::VectorXd>& lower,
                    const Eigen::Ref<const Eigen::VectorXd>& upper) const;
  Descent search(const Eigen::Ref<const Eigen::MatrixXd>& H,
                 const Eigen::Ref<const Eigen::VectorXd>& lower,
                 const Eigen::Ref<const Eigen::VectorXd>& upper);
  bool project_trial(double length, const Eigen::Ref<const Eigen::VectorXd>& lower,
                     const Eigen::Ref<const Eigen::VectorXd>& upper);

  int size_ = 0;
  int free_count_ = 0;
  int iterations_ = 0;
  Eigen::VectorXd x_, gradient_, direction_, step_, trial_, H_step_;
  LaneMatrix factor_;
  LaneMatrix rhs_;  // one row
  std::vector<int> free_;
};

}  // namespace conddp
