#pragma once

#include <utility>
#include <vector>

namespace conddp {

/// Line-search filter of Wächter and Biegler (2006, section 2.3): pairs (θ, φ) of infeasibility and
/// objective on which trials must improve in one of both.
class Filter {
 public:
  explicit Filter(int size) { entries_.reserve(size); }

  /// Sets the limits of θ from that of the first iterate, and clears the filter.
  void start(double theta);
  /// Starts with the next barrier problem.
  void clear();
  /// Forgets its points where they leave no step; θ stays below the present one from then on. False
  /// if there are none, or if it has forgotten too often in this barrier problem.
  bool forget(double theta);
  /// Judges a trial of a step of this length from (θ, φ), along which φ has the slope `slope`.
  /// Small steps must lower φ by Armijo's rule where θ is small; others must lower θ or φ, and the
  /// point that they leave joins the filter.
  bool accepts(double length, double slope, const std::pair<double, double>& from,
               const std::pair<double, double>& trial);

 private:
  std::vector<std::pair<double, double>> entries_;
  double least_ = 0;                  ///< θ below which Armijo's rule counts
  double largest_ = 0, present_ = 0;  ///< limit of θ, and that of the present barrier problem
  int forgotten_ = 0;                 ///< times
};

}  // namespace conddp
