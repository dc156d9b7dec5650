#include "analysis/derivatives/node_models.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <utility>

#include "ocp/evaluation/evaluator.hpp"
#include "spatial/aligned.hpp"
#include "spatial/lane.hpp"

namespace conddp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Allowed difference between products with a direction, relative to the sizes of their own terms
/// and to the largest terms of the matrix.
constexpr double kOwnAgreement = 1e-12, kLargestAgreement = 1e-13;

/// Allowed difference relative to an estimate of the rounding that a step amplifies. For chains of
/// 200 bodies, two such numbers differ by up to twice this estimate.
constexpr double kOverRounding = 8;

/// column ← block · column, for each of several columns.
template <int n>
void turn_columns(const double* block, double* first, Eigen::Index stride, Eigen::Index columns) {
  const Eigen::Map<const Eigen::Matrix<double, n, n, Eigen::RowMajor>> turn(block);
  for (Eigen::Index c = 0; c < columns; ++c) {
    Eigen::Map<Eigen::Matrix<double, n, 1>> column(first + c * stride);
    const Eigen::Matrix<double, n, 1> turned = turn * column;
    column = turned;
  }
}

/// Moves the rows of the next state's tangent vector from f to f ⊕ (−gap).
void transport(const StateManifold& manifold, const Eigen::Ref<const VectorXd>& gap,
               MatrixXd& step) {
  const auto& curved = manifold.curved();
  if (curved.empty()) return;
  AlignedVector<double> wrt_x(curved.size() * StateManifold::kBlockSize), wrt_dx(wrt_x.size());
  const VectorXd back = -gap;
  manifold.integrate_jacobians(back.data(), wrt_x.data(), wrt_dx.data());
  for (std::size_t s = 0; s < curved.size(); ++s)
    (curved[s].n == 6 ? turn_columns<6> : turn_columns<3>)(&wrt_x[s * StateManifold::kBlockSize],
                                                           step.data() + curved[s].dx, step.rows(),
                                                           step.cols());
}

NodeDerivatives from_linearization(const ShootingProblem& problem, int node, const MatrixXd& gap,
                                   KnotLinearization& knot) {
  NodeDerivatives out{std::move(knot.gradient), std::move(knot.C), {}};
  if (node == problem.knots()) return out;
  out.step = knot.dense_jacobian();
  transport(problem.knot(node).model->manifold(), gap.col(node), out.step);
  return out;
}

/// Columns of z.
struct ColumnRange {
  int first, count;
};

/// Products of a node's matrices with a direction, and the rounding that they may have. Rows of the
/// cost, the constraints and the step follow one another.
class NodeProducts {
 public:
  void multiply(const NodeDerivatives& d, const ColumnRange& columns, const double* direction) {
    const Eigen::Index rows = 1 + d.constraint.rows() + d.step.rows();
    value_.setZero(rows);
    allowed_.setZero(rows);
    multiply(d.cost.data(), 0, 1, columns, direction);
    multiply(d.constraint.data(), 1, d.constraint.rows(), columns, direction);
    multiply(d.step.data(), 1 + d.constraint.rows(), d.step.rows(), columns, direction);
  }

  const VectorXd& value() const { return value_; }

  /// Largest difference between two such products, relative to the rounding that they may have.
  template <class A, class B>
  double difference(const A& a, const B& b) const {
    double largest = 0;
    for (Eigen::Index i = 0; i < value_.size(); ++i) {
      const double apart = std::abs(a[i] - b[i]);
      if (apart == 0) continue;
      if (!(apart <= std::numeric_limits<double>::max() * allowed_[i]))
        return std::numeric_limits<double>::infinity();
      largest = std::max(largest, apart / allowed_[i]);
    }
    return largest;
  }

 private:
  /// Multiplies a matrix with columns for all of z by a direction in some of these columns.
  void multiply(const double* matrix, Eigen::Index first, Eigen::Index rows,
                const ColumnRange& columns, const double* direction) {
    if (rows == 0) return;
    double *value = value_.data() + first, *size = allowed_.data() + first;
    const double* column = matrix + columns.first * rows;
    for (int j = columns.first; j < columns.first + columns.count; ++j, column += rows)
      for (Eigen::Index i = 0; i < rows; ++i) {
        const double term = column[i] * direction[j];
        value[i] += term;
        size[i] += std::abs(term);
      }
    auto allowed = allowed_.segment(first, rows).array();
    const double largest = allowed.maxCoeff();
    allowed = kOwnAgreement * allowed + kLargestAgreement * largest;
  }

  VectorXd value_, allowed_;
};

/// Confirms the derivatives of nodes of one model, as many at a time as fit into the lanes.
class Confirmation {
 public:
  Confirmation(const ShootingProblem& problem, MovingNodes& moving)
      : problem_(problem), moving_(moving) {}

  static constexpr int kAtOnce = kLaneWidth / 2;

  /// Calls deny(node) for each node with unconfirmed derivatives, among at most kAtOnce nodes.
  template <class F>
  void run(std::span<const int> nodes, const std::vector<NodeDerivatives>& derivatives, F deny) {
    const KnotModel& model = *problem_.knot(nodes.front()).model;
    directions_.setZero(model.nz(), 2 * static_cast<Eigen::Index>(nodes.size()));
    for (Eigen::Index i = 0; i < directions_.cols(); ++i) {
      const ColumnRange columns = moved(model, i);
      fill(directions_.col(i).segment(columns.first, columns.count));
    }
    slopes_ = slopes(nodes, derivatives, directions_);
    thirds_.resize(0, 0);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const NodeDerivatives& of_node = derivatives[nodes[i]];
      if (!confirms(nodes, derivatives, of_node, 2 * static_cast<Eigen::Index>(i))) deny(nodes[i]);
    }
  }

 private:
  /// Columns of z along a move: those of the state for even moves, those of the control for odd
  /// ones.
  static ColumnRange moved(const KnotModel& model, Eigen::Index move) {
    return move % 2 == 0 ? ColumnRange{0, model.ndx()} : ColumnRange{model.ndx(), model.nu()};
  }

  /// Fills a direction with entries from −1 to 1, none of them small.
  void fill(Eigen::Ref<VectorXd> direction) {
    for (double& entry : direction) {
      const double size = 0.5 + 0.5 * static_cast<double>(engine_() >> 11) * 0x1p-53;
      entry = (engine_() >> 63) != 0 ? size : -size;
    }
  }

  /// Slopes by dual numbers along two directions per node: rows as in NodeProducts.
  MatrixXd slopes(std::span<const int> nodes, const std::vector<NodeDerivatives>& derivatives,
                  const MatrixXd& directions) {
    const auto moves = static_cast<std::size_t>(directions.cols());
    NodeMove list[2 * kAtOnce];
    for (std::size_t i = 0; i < moves; ++i) list[i] = {nodes[i / 2], directions.col(i).data()};
    moving_.evaluate({list, moves});
    const NodeDerivatives& d = derivatives[nodes.front()];
    MatrixXd out(1 + d.constraint.rows() + d.step.rows(), directions.cols());
    for (std::size_t i = 0; i < moves; ++i) {
      double* column = out.col(i).data();
      double* step = column + 1 + d.constraint.rows();
      moving_.write(static_cast<int>(i), {column, column + 1, d.step.size() > 0 ? step : nullptr});
    }
    return out;
  }

  /// True if the products along a node's two moves agree to rounding. A step may amplify rounding,
  /// as it does for long chains of bodies. The estimate compares the slopes with three times those
  /// along a third of the directions, because all their products are rounded differently. It is
  /// that of the node, since analytic derivatives along both moves use the same factors.
  bool confirms(std::span<const int> nodes, const std::vector<NodeDerivatives>& derivatives,
                const NodeDerivatives& d, Eigen::Index first) {
    const double apart = largest_difference(nodes, d, first, [&](Eigen::Index move) {
      return products_.difference(products_.value(), slopes_.col(move));
    });
    if (apart <= 1) return true;
    if (!std::isfinite(apart)) return false;
    if (thirds_.size() == 0) thirds_ = 3 * slopes(nodes, derivatives, directions_ / 3);
    return apart <= kOverRounding * largest_difference(nodes, d, first, [&](Eigen::Index move) {
                      return products_.difference(thirds_.col(move), slopes_.col(move));
                    });
  }

  /// The larger one of the differences of a node's two moves, whose products are made first.
  template <class Difference>
  double largest_difference(std::span<const int> nodes, const NodeDerivatives& d,
                            Eigen::Index first, Difference difference) {
    const KnotModel& model = *problem_.knot(nodes.front()).model;
    double largest = 0;
    for (Eigen::Index move = first; move < first + 2; ++move) {
      products_.multiply(d, moved(model, move), directions_.col(move).data());
      largest = std::max(largest, difference(move));
    }
    return largest;
  }

  const ShootingProblem& problem_;
  MovingNodes& moving_;
  std::mt19937_64 engine_{4};
  NodeProducts products_;
  MatrixXd directions_, slopes_, thirds_;
};

/// Nodes of each model, in order of appearance.
std::vector<std::vector<int>> nodes_by_model(const ShootingProblem& problem) {
  std::vector<std::vector<int>> lists;
  std::map<const KnotModel*, std::size_t> place;
  for (int k = 0; k <= problem.knots(); ++k) {
    const auto [found, is_new] = place.emplace(problem.knot(k).model, lists.size());
    if (is_new) lists.emplace_back();
    lists[found->second].push_back(k);
  }
  return lists;
}

}  // namespace

std::vector<Eigen::MatrixXd> hessians_of(const Linearization& model) {
  std::vector<Eigen::MatrixXd> list;
  list.reserve(model.knots.size());
  for (const KnotLinearization& knot : model.knots) list.push_back(knot.hessian());
  return list;
}

std::vector<Eigen::MatrixXd> gauss_newton_hessians(const ShootingProblem& problem,
                                                   const Trajectory& trajectory) {
  Linearization model(problem);
  Evaluator(problem).differentiate(trajectory, model);
  return hessians_of(model);
}

std::vector<Eigen::MatrixXd> exact_hessians(const ShootingProblem& problem,
                                            const Trajectory& trajectory,
                                            const Eigen::MatrixXd& costates,
                                            const Augmentation* augmentation) {
  Evaluator evaluator(problem);
  Linearization model(problem);
  evaluator.differentiate(trajectory, model, augmentation);
  evaluator.lagrangian_hessian(trajectory, costates, model, augmentation);
  return hessians_of(model);
}

NodeModels node_models(const ShootingProblem& problem, const Trajectory& trajectory,
                       const MatrixXd& gap) {
  Linearization analytic(problem);
  Evaluator(problem).differentiate(trajectory, analytic);
  return confirmed_models(problem, trajectory, gap, std::move(analytic));
}

NodeModels confirmed_models(const ShootingProblem& problem, const Trajectory& trajectory,
                            const MatrixXd& gap, Linearization analytic) {
  NodeModels models;
  models.derivatives.reserve(analytic.knots.size());
  models.hessians.reserve(analytic.knots.size());
  for (int k = 0; k <= problem.knots(); ++k) {
    KnotLinearization& knot = analytic.knots[k];
    models.derivatives.push_back(from_linearization(problem, k, gap, knot));
    models.hessians.push_back(std::move(knot.hessian.change()));
  }
  MovingNodes moving(problem, trajectory, gap);
  Confirmation confirmation(problem, moving);
  std::vector<int> denied;
  for (const std::vector<int>& nodes : nodes_by_model(problem))
    for (std::size_t first = 0; first < nodes.size(); first += Confirmation::kAtOnce)
      confirmation.run(std::span(nodes).subspan(first, std::min<std::size_t>(Confirmation::kAtOnce,
                                                                             nodes.size() - first)),
                       models.derivatives, [&](int node) { denied.push_back(node); });
  for (const int node : denied)
    models.derivatives[node] = derivatives_of_node(problem, node, moving);
  models.by_dual_numbers = static_cast<int>(denied.size());
  return models;
}

}  // namespace conddp
