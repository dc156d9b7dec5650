#include "analysis/derivatives/node_models.hpp"

#include <algorithm>
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

/// What a product with a direction may differ by: relative to the sizes of its own terms, and of
/// the largest ones of its matrix.
constexpr double kOwnAgreement = 1e-12, kLargestAgreement = 1e-13;

/// column ← block · column, in each of some columns.
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
struct Columns {
  int first, count;
};

/// Compares products of matrices and directions with what they should be.
class ProductCheck {
 public:
  /// Of a matrix with `rows` rows that has columns for all of z, and a direction in these columns.
  bool holds(const double* matrix, Eigen::Index rows, const Columns& columns,
             const double* direction, const double* expected) {
    if (rows == 0) return true;
    multiply(matrix + columns.first * rows, rows, columns.count, direction + columns.first);
    const double largest = kLargestAgreement * size_.maxCoeff();
    for (Eigen::Index i = 0; i < rows; ++i)
      if (!(std::abs(value_[i] - expected[i]) <= kOwnAgreement * size_[i] + largest)) return false;
    return true;
  }

 private:
  /// The product, and the sums of the sizes of its terms.
  void multiply(const double* column, Eigen::Index rows, int count, const double* direction) {
    value_.setZero(rows);
    size_.setZero(rows);
    double *value = value_.data(), *size = size_.data();
    for (int j = 0; j < count; ++j, column += rows)
      for (Eigen::Index i = 0; i < rows; ++i) {
        const double term = column[i] * direction[j];
        value[i] += term;
        size[i] += std::abs(term);
      }
  }

  VectorXd value_, size_;
};

/// Confirms the derivatives of nodes of one model, as many as fit into lanes at a time.
class Confirmation {
 public:
  Confirmation(const ShootingProblem& problem, MovingNodes& moving)
      : problem_(problem), moving_(moving) {}

  static constexpr int kAtOnce = kLaneWidth / 2;

  /// Calls deny(node) for those of kAtOnce or fewer nodes whose derivatives are not confirmed.
  template <class F>
  void run(std::span<const int> nodes, const std::vector<NodeDerivatives>& derivatives, F deny) {
    const KnotModel& model = *problem_.knot(nodes.front()).model;
    directions_.setZero(model.nz(), 2 * static_cast<Eigen::Index>(nodes.size()));
    NodeMove moves[2 * kAtOnce];
    for (Eigen::Index i = 0; i < directions_.cols(); ++i) {
      const Columns columns = moved(model, i);
      fill(directions_.col(i).segment(columns.first, columns.count));
      moves[i] = {nodes[i / 2], directions_.col(i).data()};
    }
    moving_.evaluate({moves, static_cast<std::size_t>(directions_.cols())});
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const NodeDerivatives& of_node = derivatives[nodes[i]];
      const int first = 2 * static_cast<int>(i);
      if (!confirms(model, of_node, first) || !confirms(model, of_node, first + 1)) deny(nodes[i]);
    }
  }

 private:
  /// The columns of z along which a move goes: those of the state, then those of the control.
  static Columns moved(const KnotModel& model, Eigen::Index move) {
    return move % 2 == 0 ? Columns{0, model.ndx()} : Columns{model.ndx(), model.nu()};
  }

  /// Entries from −1 to 1, none of which is small.
  void fill(Eigen::Ref<VectorXd> direction) {
    for (double& entry : direction) {
      const double size = 0.5 + 0.5 * static_cast<double>(engine_() >> 11) * 0x1p-53;
      entry = (engine_() >> 63) != 0 ? size : -size;
    }
  }

  bool confirms(const KnotModel& model, const NodeDerivatives& d, int move) {
    double cost = 0;
    constraint_.resize(d.constraint.rows());
    step_.resize(d.step.rows());
    moving_.write(move, {&cost, constraint_.data(), step_.size() > 0 ? step_.data() : nullptr});
    const Columns columns = moved(model, move);
    const double* direction = directions_.col(move).data();
    return check_.holds(d.cost.data(), 1, columns, direction, &cost) &&
           check_.holds(d.constraint.data(), d.constraint.rows(), columns, direction,
                        constraint_.data()) &&
           check_.holds(d.step.data(), d.step.rows(), columns, direction, step_.data());
  }

  const ShootingProblem& problem_;
  MovingNodes& moving_;
  std::mt19937_64 engine_{4};
  ProductCheck check_;
  MatrixXd directions_;
  VectorXd constraint_, step_;
};

/// The nodes of each model, in the order in which they come.
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
