#include "ocp/problem/contradiction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "ocp/problem/node_values.hpp"

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The feasible interval of a coordinate, measured from the initial state and zero controls.
struct Interval {
  double lower = -kInfinity, upper = kInfinity;
  double rounding = 0;    ///< of both ends
  std::string name = {};  ///< of the last constraint that narrowed it; empty: control bounds
};

/// A row g = value + slope · z of one coordinate z, and its bounds.
struct Row {
  const std::string& name;
  double value, slope, lower, upper;

  Interval allowed() const {
    const double first = (lower - value) / slope, second = (upper - value) / slope;
    return {std::min(first, second), std::max(first, second), rounding(), name};
  }
  /// The values at an interval's ends in ascending order.
  std::pair<double, double> values(const Interval& z) const {
    return std::minmax(value + slope * z.lower, value + slope * z.upper);
  }

 private:
  /// Rounding of differences: touching bounds may miss each other by this much.
  double rounding() const {
    double size = 1 + std::abs(value);
    for (const double bound : {lower, upper})
      if (std::isfinite(bound)) size += std::abs(bound);
    return 1e-12 * size / std::abs(slope);
  }
};

/// Remaining intervals of the coordinates, one node after another.
class Narrowing {
 public:
  explicit Narrowing(const ShootingProblem& problem) : problem_(problem), nodes_(problem) {}

  /// Constraints must be added node by node.
  std::optional<Contradiction> add(const NodeConstraint& c) {
    if (c.node != node_) begin(c.node);
    if (c.term->kind != ConstraintKind::bounds || c.is_soft()) return std::nullopt;
    int first = 0;
    const double* slopes = slopes_->data() + c.term->jacobian;
    for (const RowBlock& block : c.term->blocks) {
      const int place = place_of_unknown(block);
      for (int row = 0; place >= 0 && row < block.rows; ++row) {
        const double value = (*values_)[c.term->row + first + row];
        const double slope = slopes[place * block.rows + row];
        const Row known{c.term->name, value, slope, c.lower[first + row], c.upper[first + row]};
        if (auto found = narrow(known, coordinates_[block.columns[place]])) return found;
      }
      first += block.rows;
      slopes += block.rows * block.columns.size();
    }
    return std::nullopt;
  }

 private:
  /// The place of the only unknown column of affine rows, −1 if it is not unique. The state of node
  /// 0 is known.
  int place_of_unknown(const RowBlock& block) const {
    int place = -1;
    for (int i = 0; i < static_cast<int>(block.columns.size()); ++i) {
      const bool known = node_ == 0 && block.columns[i] < problem_.knot(0).model->ndx();
      if (known && block.columns.size() > 1) continue;
      if (place >= 0) return -1;
      place = i;
    }
    return block.affine ? place : -1;
  }

  /// Resets to the control bounds and evaluates the constraints at the initial state.
  void begin(int node) {
    node_ = node;
    const KnotModel& model = *problem_.knot(node).model;
    coordinates_.clear();
    for (int i = 0; i < model.nu(); ++i)
      coordinates_[model.ndx() + i] = {model.control_lower()[i], model.control_upper()[i]};
    const std::vector<double> u(model.nu(), 0.0);
    const double* x = problem_.initial_state().data();
    // Slopes of affine rows belong to the model and are the same at all of its nodes.
    auto& slopes = slopes_of_[&model];
    if (slopes.empty()) slopes = nodes_.derivatives_at(node, x, u.data()).constraint_jacobian;
    slopes_ = &slopes;
    values_ = &nodes_.at(node, x, u.data()).constraint;
  }

  std::optional<Contradiction> narrow(const Row& row, Interval& known) const {
    const bool measures = std::isfinite(row.value) && std::isfinite(row.slope) && row.slope != 0;
    if (!measures) return std::nullopt;
    const Interval allowed = row.allowed();
    const double rounding = allowed.rounding + known.rounding;
    if (allowed.lower > known.upper + rounding || allowed.upper < known.lower - rounding) {
      const auto [lower, upper] = row.values(known);
      return Contradiction{row.name, known.name, node_, std::max(row.lower, lower),
                           std::min(row.upper, upper)};
    }
    if (allowed.lower > known.lower || allowed.upper < known.upper) known.name = row.name;
    known.lower = std::max(known.lower, allowed.lower);
    known.upper = std::min(known.upper, allowed.upper);
    known.rounding = std::max(known.rounding, allowed.rounding);
    return std::nullopt;
  }

  const ShootingProblem& problem_;
  NodeEvaluation nodes_;
  int node_ = -1;
  std::map<int, Interval> coordinates_;
  std::map<const KnotModel*, AlignedVector<double>> slopes_of_;
  const AlignedVector<double>*slopes_ = nullptr, *values_ = nullptr;
};

}  // namespace

std::optional<Contradiction> find_contradiction(const ShootingProblem& problem) {
  Narrowing narrowing(problem);
  for (const NodeConstraint& c : problem.constraints())
    if (auto found = narrowing.add(c)) return found;
  return std::nullopt;
}

}  // namespace conddp
