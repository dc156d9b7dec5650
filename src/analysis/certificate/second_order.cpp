#include "analysis/certificate/second_order.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string_view>

#include <Eigen/QR>

#include "analysis/certificate/motion_ranges.hpp"
#include "analysis/certificate/small_matrices.hpp"
#include "analysis/derivatives/node_models.hpp"
#include "base/matrix_decompositions.hpp"
#include "ocp/evaluation/evaluator.hpp"

namespace conddp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A multiplier is weak if moving by all ranges changes the cost by less than this share.
constexpr double kWeak = 1e-8;
/// A value is at its bound within this distance, relative to its terms.
constexpr double kNear = 1e-7;
/// Derivatives of a row below this share of those of other rows are rounding, like its changes
/// below this share of a step.
constexpr double kNothing = 1e-12;
/// Rows of unit length are dependent below this pivot. The value contains squares of gains, which
/// are inverse to the pivot.
constexpr double kRank = 1e-8;
/// Thresholds for eigenvalues relative to the terms they come from; rounding lies between the two.
constexpr double kPositive = 1e-13, kNegative = 1e-8;
/// Smallest gain that counts where elimination finds no positive curvature, as a share of the cost.
constexpr double kLeastGain = 1e-6;
/// Share of the cost change over all ranges that counts as nothing: moves by 3·10⁻¹⁰ of the ranges.
constexpr double kResolution = 1e-19;
/// Smallest repair that counts, as a share of the resolution: at rest, all other figures are zero.
constexpr double kRepair = 1e-5;
/// Weight of a slope relative to a gain: curvature ends the decrease along a slope.
constexpr double kSlopeShare = 1e-4;
/// Limit on the searches for inactive rows that stop Newton's step.
constexpr int kRounds = 16;
/// Penalties on held rows, as shares of the cost: rounding grows with the penalty, and so does the
/// room for negative curvature across the rows.
constexpr double kPenalties[] = {1, 1e2, 1e4, 1e6};

/// A row aᵀz of a node, in units of the ranges: held, possibly held, or limiting a step.
struct Row {
  enum class Role { held, weak, open };
  VectorXd a;  ///< of unit length
  Role role = Role::open;
  double off = 0;      ///< required change of a held row
  double pressed = 0;  ///< ν (g − bound) of a held row
  /// Distances down and up to the bounds.
  double down = std::numeric_limits<double>::infinity();
  double up = std::numeric_limits<double>::infinity();
  const ConstraintTerm* equation = nullptr;  ///< null for rows of inequalities and control bounds

  /// Share of a step z that the bounds allow. Rounding of z moves rows, too, and such changes do
  /// not count: a row at its bound would stop every step along it.
  double way(const VectorXd& z) const {
    const double change = a.dot(z);
    if (std::abs(change) <= kNothing * z.lpNorm<Eigen::Infinity>()) return 1;
    return std::min(1.0, (change > 0 ? up : down) / std::abs(change));
  }
};

/// A node in units of the ranges.
struct ScaledNode {
  MatrixXd hessian, step;  ///< nz x nz; ndx x nz
  VectorXd gradient, gap;
  VectorXd reach;  ///< largest move along a direction: one range, or that of other controls
  std::vector<Row> rows;
  std::vector<Row::Role> controls;  ///< role of each control, by its bounds
};

/// Boundary ‖v‖ − t of a cone: its value, its derivative, and the Hessian of ‖v‖.
struct ConeBoundary {
  explicit ConeBoundary(const VectorXd& g)
      : axis(g.head(g.size() - 1)), length(axis.norm()), value(length - g[g.size() - 1]) {}
  VectorXd row(const MatrixXd& C) const {
    return C.topRows(axis.size()).transpose() * (axis / length) - C.row(axis.size()).transpose();
  }
  MatrixXd curvature(const MatrixXd& C) const {
    const MatrixXd J = C.topRows(axis.size());
    const VectorXd along = J.transpose() * (axis / length);
    return (J.transpose() * J - along * along.transpose()) / length;
  }

  VectorXd axis;
  double length, value;
};

/// The nodes of a point, and the roles of their rows.
class Model {
 public:
  explicit Model(const JudgedPoint& point)
      : point_(point), ranges_(point.problem, point.trajectory) {
    Augmentation lagrangian(point.problem);
    lagrangian.multiplier = point.multipliers;
    std::vector<MatrixXd> hessians =
        exact_hessians(point.problem, point.trajectory, point.costates, &lagrangian);
    units_ = ranges_.unit(point.problem, point.problem.knots());
    const double change = change_over_ranges();
    size_ = std::min(point.cost_size, change);
    resolution_ = std::max(kResolution * change, point.negligible);
    const int N = point.problem.knots();
    nodes_.resize(N + 1);
    for (int k = 0; k <= N; ++k) scale(k, std::move(hessians[k]));
    for (const NodeConstraint& c : point.problem.constraints()) add(c);
    for (int k = 0; k <= N; ++k) finish(k);
  }

  const std::vector<ScaledNode>& nodes() const { return nodes_; }
  double cost_size() const { return size_; }
  double resolution() const { return resolution_; }
  double negligible() const { return point_.negligible; }
  VectorXd unit(int k) const { return ranges_.unit(point_.problem, k); }
  /// Σ |∂L/∂u| times the ranges, over controls that no bound holds; 0 without constraints.
  double slope() const {
    double sum = 0;
    if (point_.problem.constraints().empty()) return 0;
    const int ndx = point_.problem.ndx();
    for (int k = 0; k < point_.problem.knots(); ++k)
      for (int i = 0; i < point_.problem.nu(k); ++i)
        if (nodes_[k].controls[i] != Row::Role::held)
          sum +=
              std::abs(point_.control_gradient[k][i]) * ranges_.of_node(point_.problem, k)[ndx + i];
    return sum;
  }

 private:
  /// Cost change if all states and controls move by their ranges, summed over the nodes.
  double change_over_ranges() const {
    const ShootingProblem& problem = point_.problem;
    Trajectory moved = point_.trajectory;
    for (int k = 0; k <= problem.knots(); ++k) {
      const VectorXd range = ranges_.of_node(problem, k);
      problem.manifold().integrate(moved.x(k).data(), range.data(), moved.x(k).data());
      if (k < problem.knots()) moved.u(k) += range.tail(problem.nu(k));
    }
    Evaluator evaluator(problem);
    Evaluation here(problem), there(problem);
    evaluator.evaluate(point_.trajectory, here);
    evaluator.evaluate(moved, there);
    double sum = 0;
    for (int k = 0; k <= problem.knots(); ++k)
      if (const double change = std::abs(there.cost[k] - here.cost[k]); std::isfinite(change))
        sum += change;
    return sum;
  }

  void scale(int k, MatrixXd hessian) {
    const VectorXd unit = this->unit(k);
    ScaledNode& node = nodes_[k];
    const NodeDerivatives& d = point_.derivatives[k];
    node.hessian = unit.asDiagonal() * hessian * unit.asDiagonal();
    VectorXd gradient = d.cost;
    if (d.constraint.rows() > 0)
      gradient +=
          d.constraint.transpose() *
          point_.multipliers.segment(point_.problem.constraint_offset(k), d.constraint.rows());
    node.gradient = unit.cwiseProduct(gradient);
    node.reach = ranges_.reach(point_.problem, k);
    if (k == point_.problem.knots()) return;
    node.step = units_.cwiseInverse().asDiagonal() * d.step * unit.asDiagonal();
    node.gap = units_.cwiseInverse().cwiseProduct(point_.gap.col(k));
    bound(k);
  }

  void bound(int k) {
    const KnotModel& model = *point_.problem.knot(k).model;
    const VectorXd unit = this->unit(k);
    const int ndx = point_.problem.ndx();
    for (int i = 0; i < point_.problem.nu(k); ++i) {
      const double u = point_.trajectory.u(k)[i], range = unit[ndx + i];
      const double slope = point_.control_gradient[k][i];
      const double down = u - model.control_lower()[i], up = model.control_upper()[i] - u;
      const double near = kNear * std::max(range, std::abs(u));
      const bool at_lower = down <= near, at_upper = up <= near;
      Row row{VectorXd::Unit(unit.size(), ndx + i)};
      row.down = std::max(0.0, down) / range;
      row.up = std::max(0.0, up) / range;
      if ((at_lower && at_upper) || (at_lower && slope * range > kWeak * size_) ||
          (at_upper && -slope * range > kWeak * size_))
        row.role = Row::Role::held;
      else if ((at_lower || at_upper) && std::abs(slope) * range <= kWeak * size_)
        row.role = Row::Role::weak;
      nodes_[k].controls.push_back(row.role);
      if (std::isfinite(down) || std::isfinite(up)) nodes_[k].rows.push_back(std::move(row));
    }
  }

  /// Jacobian of a constraint in units of the ranges.
  MatrixXd jacobian(const NodeConstraint& c) const {
    return point_.derivatives[c.node].constraint.middleRows(
               c.row - point_.problem.constraint_offset(c.node), c.term->rows) *
           unit(c.node).asDiagonal();
  }

  void add(const NodeConstraint& c) {
    if (c.term->softness == Softness::l2) return;
    const MatrixXd C = jacobian(c);
    const VectorXd g = point_.values.segment(c.row, c.term->rows),
                   nu = point_.multipliers.segment(c.row, c.term->rows);
    if (c.term->is_cone()) return add_cone(c, C, g, nu);
    for (int i = 0; i < c.term->rows; ++i)
      if (c.term->has_pairs())
        add_of_pair(c, C.row(i), C.row(i ^ 1), g, nu, i);
      else
        add_bounded(c, C.row(i), g[i], nu[i], c.lower[i], c.upper[i]);
  }

  /// Holds the smaller entry of a pair. If both vanish, each entry that the cost presses down is
  /// held; an entry whose growth lowers the cost is released, without its multiplier.
  void add_of_pair(const NodeConstraint& c, const VectorXd& a, const VectorXd& of_other,
                   const VectorXd& g, const VectorXd& nu, int i) {
    const int other = i ^ 1;
    const auto vanishes = [&](int j, const VectorXd& row) {
      return std::abs(g[j]) <= kNear * row.lpNorm<1>();
    };
    const auto press = [&](int j, const VectorXd& row) {
      return -nu[j] * row.lpNorm<Eigen::Infinity>() / (kWeak * size_);
    };
    const bool smaller = g[i] < g[other] || (g[i] == g[other] && i < other);
    const bool both = vanishes(i, a) && vanishes(other, of_other);
    const double mine = press(i, a), theirs = press(other, of_other);
    const bool lifts = both && mine < -1 && (theirs >= -1 || !smaller);
    Row row{a};
    row.down = std::max(0.0, g[i]);
    if (lifts) {
      nodes_[c.node].gradient -= nu[i] * a;
    } else if (smaller || (both && (mine > 1 || theirs < -1))) {
      row.role = Row::Role::held;
      row.off = -g[i];
      row.pressed = nu[i] * g[i];
      row.down = std::numeric_limits<double>::infinity();
    } else if (both) {
      row.role = Row::Role::weak;
    }
    nodes_[c.node].rows.push_back(std::move(row));
  }

  void add_bounded(const NodeConstraint& c, const VectorXd& a, double g, double nu, double lower,
                   double upper) {
    Row row{a};
    const double terms = a.lpNorm<1>(), near = kNear * std::max(terms, std::abs(g));
    bool pushed = std::abs(nu) * a.lpNorm<Eigen::Infinity>() > kWeak * size_;
    // A violated soft row has a constant cost per distance, so it is not held.
    const bool paid = c.is_soft() && std::abs(nu) >= (1 - kNear) * c.limit;
    // A violation must be repaired, whatever the multiplier.
    const bool below = !c.is_soft() && g < lower - near, above = !c.is_soft() && g > upper + near;
    const double bound = below || (!above && (lower == upper || nu < 0)) ? lower : upper;
    // Interior-point methods leave multipliers at distant bounds. The larger one of push and
    // distance counts, in shares of the costs and in ranges.
    const double off = std::abs(bound - g);
    if (pushed && lower != upper && off > near && std::abs(nu) * a.squaredNorm() < size_ * off) {
      pushed = false;
      nodes_[c.node].gradient -= nu * a;
    }
    if (!paid && (lower == upper || below || above || (pushed && std::isfinite(bound)))) {
      row.role = Row::Role::held;
      row.off = bound - g;
      row.pressed = nu * (g - bound);
      if (lower == upper) row.equation = c.term;
    } else if (!paid && (g <= lower + near || g >= upper - near)) {
      row.role = Row::Role::weak;
    }
    if (!c.is_soft() && lower != upper) {
      row.down = std::max(0.0, g - lower);
      row.up = std::max(0.0, upper - g);
    }
    nodes_[c.node].rows.push_back(std::move(row));
  }

  void add_cone(const NodeConstraint& c, const MatrixXd& C, const VectorXd& g, const VectorXd& nu) {
    const ConeBoundary boundary(g);
    const double push = nu.head(nu.size() - 1).norm(), size = g.lpNorm<1>();
    const double terms = C.cwiseAbs().rowwise().sum().maxCoeff();
    const bool pushed = nu.norm() * C.cwiseAbs().maxCoeff() > kWeak * size_;
    const bool paid = c.is_soft() && nu.norm() >= (1 - kNear) * c.limit;
    ScaledNode& node = nodes_[c.node];
    if (boundary.length <= kNear * std::max(terms, size)) {
      if (pushed && !paid)  // the apex
        for (Index i = 0; i < C.rows(); ++i)
          node.rows.push_back({C.row(i), Row::Role::held, -g[i], nu[i] * g[i]});
      return;
    }
    if (push > 0) node.hessian += push * boundary.curvature(C);
    Row row{boundary.row(C)};
    if (pushed && !paid) {
      row.role = Row::Role::held;
      row.off = -boundary.value;
      row.pressed = nu.dot(g);
    } else if (!paid && std::abs(boundary.value) <= kNear * std::max(terms, size)) {
      row.role = Row::Role::weak;
    }
    if (!c.is_soft()) row.up = std::max(0.0, -boundary.value);
    node.rows.push_back(std::move(row));
  }

  /// Scales rows to unit length; rows that are rounding become zero.
  void finish(int k) {
    double longest = 0;
    for (const Row& row : nodes_[k].rows) longest = std::max(longest, row.a.norm());
    for (Row& row : nodes_[k].rows) {
      const double length = row.a.norm();
      if (length <= kNothing * longest) {
        row.a.setZero();
        row.role = Row::Role::open;
        continue;
      }
      row.a /= length;
      for (double Row::*number : {&Row::off, &Row::down, &Row::up}) row.*number /= length;
    }
  }

  const JudgedPoint& point_;
  MotionRanges ranges_;
  VectorXd units_;
  double size_ = 0, resolution_ = 0;
  std::vector<ScaledNode> nodes_;
};

/// Rows G x = h on a state: G has orthonormal rows, h one column per right-hand side.
struct StateRows {
  MatrixXd G, h;
};

/// Drops dependent rows.
StateRows independent(MatrixXd A, MatrixXd rhs) {
  for (Index i = 0; i < A.rows(); ++i)
    if (const double length = A.row(i).norm(); length > 0) {
      A.row(i) /= length;
      rhs.row(i) /= length;
    }
  Eigen::ColPivHouseholderQR<MatrixXd> qr(A.transpose());
  qr.setThreshold(kRank);
  const Index rank = qr.rank();
  const MatrixXd ordered = qr.colsPermutation().transpose() * rhs;
  StateRows out;
  out.G = (qr.householderQ() * MatrixXd::Identity(A.cols(), rank)).transpose();
  out.h = qr.matrixR()
              .topLeftCorner(rank, rank)
              .triangularView<Eigen::Upper>()
              .transpose()
              .solve(ordered.topRows(rank));
  return out;
}

/// Largest share of a step before an inactive row stops it.
double step_length(const std::vector<ScaledNode>& nodes, const std::vector<VectorXd>& step,
                   double sign) {
  double length = 1;
  for (std::size_t k = 0; k < nodes.size(); ++k)
    for (const Row& row : nodes[k].rows)
      if (row.role != Row::Role::held) length = std::min(length, row.way(sign * step[k]));
  return length;
}

/// A direction of negative curvature, scaled until an entry reaches its limit.
struct Descent {
  std::vector<VectorXd> z;
  double bend = 0;    ///< ½ zᵀ H z
  double length = 0;  ///< largest share of z or −z until a row stops it

  double gain() const { return -bend * length * length; }
  void measure(const std::vector<ScaledNode>& nodes) {
    double largest = 0;
    for (std::size_t k = 0; k < z.size(); ++k)
      largest = std::max(largest, z[k].cwiseQuotient(nodes[k].reach).lpNorm<Eigen::Infinity>());
    for (std::size_t k = 0; k < z.size(); ++k) {
      z[k] /= largest;
      bend += 0.5 * z[k].dot(nodes[k].hessian * z[k]);
    }
    length = std::max(step_length(nodes, z, 1), step_length(nodes, z, -1));
  }
};

/// Riccati recursion with two right-hand sides: with violations closed, and without.
class Recursion {
 public:
  static constexpr Index kSides = 2;

  /// Negative curvature counts where it gains more than `least_gain`.
  Recursion(const std::vector<ScaledNode>& nodes, double least_gain)
      : nodes_(nodes), least_gain_(least_gain) {}

  /// Sweeps from the last node to the first. Returns false if a stage has negative curvature.
  bool run() {
    const int N = static_cast<int>(nodes_.size()) - 1;
    stages_.assign(N, {});
    enter_terminal();
    for (int k = N - 1; k >= 0; --k)
      if (!enter(k)) return false;
    return true;
  }

  /// Least values of the model: with violations closed, and without.
  Eigen::RowVector2d least_values() const { return constant_; }
  /// Largest cost decrease along a direction without curvature, over one range or until an inactive
  /// row stops it.
  double flat_gain() const { return flat_gain_; }
  /// Smallest eigenvalue of the stages that are not positive beyond rounding, relative to their
  /// terms, and its knot; infinite if all stages are positive.
  double least() const { return least_; }
  int least_knot() const { return least_knot_; }
  /// Sum of ν (g − bound) over all held rows.
  double pressed() const {
    double sum = 0;
    for (const ScaledNode& node : nodes_)
      for (const Row& row : node.rows)
        if (row.role == Row::Role::held) sum += row.pressed;
    return sum;
  }

  /// Largest move that closes the violations of held rows and the gaps, as a multiple of the
  /// largest of these.
  double amplification() const {
    double move = 0, off = 0;
    VectorXd x = VectorXd::Zero(nodes_.back().hessian.rows());
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      for (const Row& row : nodes_[k].rows)
        if (row.role == Row::Role::held) off = std::max(off, std::abs(row.off));
      if (k == stages_.size()) break;
      off = std::max(off, nodes_[k].gap.lpNorm<Eigen::Infinity>());
      const Stage& stage = stages_[k];
      const VectorXd z = moved(k, x, stage.K * x + stage.k.col(0) - stage.k.col(1));
      move = std::max(move, z.lpNorm<Eigen::Infinity>());
      x += nodes_[k].gap;
    }
    return off > 0 ? move / off : 0;
  }

  /// Newton's step along the active rows: z of each node.
  std::vector<VectorXd> step() const {
    std::vector<VectorXd> list;
    VectorXd x = VectorXd::Zero(nodes_.back().hessian.rows());
    for (std::size_t k = 0; k < stages_.size(); ++k)
      list.push_back(moved(k, x, stages_[k].K * x + stages_[k].k.col(1)));
    list.push_back(x);
    return list;
  }

  /// Direction of the negative curvature that ended run().
  const Descent& descent() const { return found_; }

 private:
  struct Stage {
    MatrixXd K, k;  ///< δu = K δx + k, one column of k per right-hand side
  };

  /// Starts from rest with controls at one knot, then follows the gains of the later knots.
  Descent direction(int knot, const VectorXd& start) const {
    Descent out;
    VectorXd x = VectorXd::Zero(nodes_.back().hessian.rows());
    for (std::size_t k = 0; k < stages_.size(); ++k) {
      VectorXd u = VectorXd::Zero(nodes_[k].controls.size());
      if (static_cast<int>(k) == knot) u = start;
      if (static_cast<int>(k) > knot) u = stages_[k].K * x;
      out.z.push_back(moved(k, x, u));
    }
    out.z.push_back(x);
    out.measure(nodes_);
    return out;
  }

  VectorXd moved(std::size_t k, VectorXd& x, const VectorXd& u) const {
    VectorXd z(x.size() + u.size());
    z << x, u;
    x = nodes_[k].step * z;
    return z;
  }

  void enter_terminal() {
    const ScaledNode& node = nodes_.back();
    const Index n = node.hessian.rows();
    P_ = node.hessian;
    p_ = node.gradient.replicate(1, kSides);
    E_ = bound_of(node.hessian, VectorXd::Zero(n)).asDiagonal();
    constant_.setZero();
    rows_ = {MatrixXd(0, n), MatrixXd(0, kSides)};
    MatrixXd E, e;
    gather(node, E, e);
    if (E.rows() > 0) rows_ = independent(E, e);
  }

  /// Gathers the held rows of a node and those of the next node, expressed in this node's z.
  void gather(const ScaledNode& node, MatrixXd& E, MatrixXd& e) const {
    const Index nz = node.hessian.rows();
    const bool terminal = node.step.rows() == 0;
    Index count = terminal ? 0 : rows_.G.rows();
    for (const Row& row : node.rows) count += row.role == Row::Role::held ? 1 : 0;
    E.resize(count, nz);
    e.setZero(count, kSides);
    Index next = 0;
    if (!terminal && rows_.G.rows() > 0) {
      next = rows_.G.rows();
      E.topRows(next) = rows_.G * node.step;
      e.topRows(next) = rows_.h;
      e.topRows(next).col(0) -= rows_.G * node.gap;
    }
    for (const Row& row : node.rows)
      if (row.role == Row::Role::held) {
        E.row(next) = row.a;
        e(next++, 0) = row.off;
      }
  }

  bool enter(int k) {
    const ScaledNode& node = nodes_[k];
    const Index n = p_.rows(), nu = static_cast<Index>(node.controls.size()), nz = n + nu;
    multiply(P_, node.step, PF_);
    transposed_ = node.step.transpose();
    multiply_lower(transposed_, PF_, Q_);
    Q_ += node.hessian;
    mirror_lower_triangle(Q_);
    const MatrixXd terms = terms_of_controls(node, nu);
    MatrixXd q(nz, kSides);
    MatrixXd ahead = p_;
    ahead.col(0) += P_ * node.gap;
    q = transposed_ * ahead;
    q.colwise() += node.gradient;
    constant_[0] += p_.col(0).dot(node.gap) + 0.5 * node.gap.dot(P_ * node.gap);
    MatrixXd E, e;
    gather(node, E, e);
    return E.rows() == 0 ? minimize_free(k, q, terms, n, nu) : minimize(k, E, e, q, terms, n, nu);
  }

  /// Minimizes a stage without active rows.
  bool minimize_free(int k, const MatrixXd& q, const MatrixXd& terms, Index n, Index nu) {
    rows_ = {MatrixXd(0, n), MatrixXd(0, kSides)};
    return reduce(k, MatrixXd::Identity(nu, nu), MatrixXd::Zero(nu, n), MatrixXd::Zero(nu, kSides),
                  q, terms, n, nu);
  }

  bool minimize(int k, const MatrixXd& E, const MatrixXd& e, const MatrixXd& q,
                const MatrixXd& terms, Index n, Index nu) {
    const Index m = E.rows();
    VectorXd length = E.rowwise().norm().cwiseMax(std::numeric_limits<double>::min());
    const MatrixXd Ex = length.cwiseInverse().asDiagonal() * E.leftCols(n);
    const MatrixXd Eu = length.cwiseInverse().asDiagonal() * E.rightCols(nu);
    const MatrixXd r = length.cwiseInverse().asDiagonal() * e;
    Eigen::ColPivHouseholderQR<MatrixXd> qr(nu, m);
    qr.setThreshold(kRank);
    MatrixXd Z = MatrixXd::Identity(nu, nu), Ux = MatrixXd::Zero(nu, n),
             U0 = MatrixXd::Zero(nu, kSides);
    MatrixXd left_x = Ex, left_r = r;
    // Pivots are relative to rows of unit length; a control that moves no row yields none.
    Index rank = 0;
    if (nu > 0) {
      qr.compute(Eu.transpose());
      const auto R = qr.matrixR();
      while (rank < std::min(nu, m) && std::abs(R(rank, rank)) > kRank) ++rank;
      const MatrixXd basis = qr.householderQ() * MatrixXd::Identity(nu, nu);
      const MatrixXd px = qr.colsPermutation().transpose() * Ex,
                     pr = qr.colsPermutation().transpose() * r;
      const auto R1 = R.topLeftCorner(rank, rank).template triangularView<Eigen::Upper>();
      const MatrixXd yx = R1.transpose().solve(px.topRows(rank)),
                     yr = R1.transpose().solve(pr.topRows(rank));
      Ux = -basis.leftCols(rank) * yx;
      U0 = basis.leftCols(rank) * yr;
      Z = basis.rightCols(nu - rank);
      const MatrixXd R2 = R.topRightCorner(rank, m - rank);
      left_x = px.bottomRows(m - rank) - R2.transpose() * yx;
      left_r = pr.bottomRows(m - rank) - R2.transpose() * yr;
    }
    keep(left_x, left_r, n);
    const MatrixXd Quu = Q_.bottomRightCorner(nu, nu);
    for (Index c = 0; c < kSides; ++c)
      constant_[c] += U0.col(c).dot(q.bottomRows(nu).col(c)) + 0.5 * U0.col(c).dot(Quu * U0.col(c));
    return reduce(k, Z, Ux, U0, q, terms, n, nu);
  }

  /// Keeps the rows that no control of this node satisfies, and drops rounding.
  void keep(const MatrixXd& left_x, const MatrixXd& left_r, Index n) {
    std::vector<Index> kept;
    for (Index i = 0; i < left_x.rows(); ++i)
      if (left_x.row(i).norm() > kRank) kept.push_back(i);
    if (kept.empty())
      rows_ = {MatrixXd(0, n), MatrixXd(0, kSides)};
    else
      rows_ = independent(left_x(kept, Eigen::all), left_r(kept, Eigen::all));
  }

  /// Minimizes over w in u = Ux x + U0 + Z w.
  bool reduce(int k, const MatrixXd& Z, const MatrixXd& Ux, const MatrixXd& U0, const MatrixXd& q,
              const MatrixXd& terms, Index n, Index nu) {
    Stage& stage = stages_[k];
    stage.K = Ux;
    stage.k = U0;
    if (Z.cols() > 0) {
      const MatrixXd Quu = Q_.bottomRightCorner(nu, nu);
      const MatrixXd Qwx = Z.transpose() * (Q_.bottomLeftCorner(nu, n) + Quu * Ux);
      const MatrixXd qw = Z.transpose() * (q.bottomRows(nu) + Quu * U0);
      const MatrixXd Qww = Z.transpose() * Quu * Z;
      const VectorXd own = (Z.transpose() * terms * Z).diagonal();
      MatrixXd wx, w0;
      if (!solve(k, Z, Qww, own, Qwx, qw, wx, w0)) return false;
      stage.K += Z * wx;
      stage.k += Z * w0;
      for (Index c = 0; c < kSides; ++c) constant_[c] += 0.5 * qw.col(c).dot(w0.col(c));
    }
    propagate(nodes_[k], stage, n, nu);
    return true;
  }

  /// Value along u = K x + k, as a sum without differences. Hessian terms of a stiff cost cancel in
  /// the closed loop, not between large numbers.
  void propagate(const ScaledNode& node, const Stage& stage, Index n, Index nu) {
    closed_ = node.step.leftCols(n);
    closed_.noalias() += node.step.rightCols(nu) * stage.K;
    MatrixXd ahead = node.step.rightCols(nu) * stage.k;
    ahead.col(0) += node.gap;
    const MatrixXd pushed = p_ + P_ * ahead;
    const MatrixXd& H = node.hessian;
    const MatrixXd HK = H.bottomRightCorner(nu, nu) * stage.K + H.bottomLeftCorner(nu, n);
    const MatrixXd along = node.gradient.replicate(1, kSides) + H.rightCols(nu) * stage.k;
    p_ = closed_.transpose() * pushed + along.topRows(n) +
         stage.K.transpose() * along.bottomRows(nu);
    carry_rounding(H, stage, n, nu);
    multiply(P_, closed_, PF_);
    transposed_ = closed_.transpose();
    multiply_lower(transposed_, PF_, P_);
    P_ += H.topLeftCorner(n, n) + stage.K.transpose() * HK +
          H.bottomLeftCorner(nu, n).transpose() * stage.K;
    mirror_lower_triangle(P_);
  }

  /// Diagonal that bounds every matrix with entries of these sizes in every direction, whatever the
  /// units of its rows. It includes `at_least`.
  static VectorXd bound_of(const MatrixXd& entries, const VectorXd& at_least) {
    const VectorXd root = (at_least + entries.diagonal().cwiseAbs()).cwiseSqrt();
    const VectorXd inverse = root.unaryExpr([](double r) { return r > 0 ? 1 / r : 0.0; });
    return at_least + root.cwiseProduct(entries.cwiseAbs() * inverse);
  }

  /// Diagonal that bounds |F|ᵀ |P| |F|, from |P_ij| ≤ √(P_ii P_jj).
  VectorXd pulled_bound(const Eigen::Ref<const MatrixXd>& F) const {
    const VectorXd a = F.cwiseAbs().transpose() * P_.diagonal().cwiseAbs().cwiseSqrt();
    return static_cast<double>(a.size()) * a.cwiseAbs2();
  }

  /// Terms of the controls' block of Q, nu x nu; rounding is relative to them.
  MatrixXd terms_of_controls(const ScaledNode& node, Index nu) const {
    const auto Fu = node.step.rightCols(nu);
    MatrixXd terms = Fu.transpose() * (E_ * Fu);
    terms.diagonal() += bound_of(node.hessian.bottomRightCorner(nu, nu), pulled_bound(Fu));
    return terms;
  }

  /// Terms of the value along the closed loop, from those of P_, the value of the next node.
  void carry_rounding(const MatrixXd& H, const Stage& stage, Index n, Index nu) {
    const MatrixXd K = stage.K.cwiseAbs(), Hux = H.bottomLeftCorner(nu, n).cwiseAbs();
    MatrixXd own = H.topLeftCorner(n, n).cwiseAbs() + Hux.transpose() * K;
    own += K.transpose() * (Hux + H.bottomRightCorner(nu, nu).cwiseAbs() * K);
    multiply(E_, closed_, PF_);
    E_.noalias() = closed_.transpose() * PF_;
    E_.diagonal() += bound_of(own, pulled_bound(closed_));
  }

  /// Minimizes over w with Hessian Qww; the solution is w = wx x + w0. Returns false if Qww is
  /// negative along some w.
  bool solve(int k, const MatrixXd& Z, const MatrixXd& Qww, const VectorXd& terms,
             const MatrixXd& Qwx, const MatrixXd& qw, MatrixXd& wx, MatrixXd& w0) {
    const VectorXd unit = terms.unaryExpr([](double t) { return t > 0 ? 1 / std::sqrt(t) : 1.0; });
    const MatrixXd scaled = unit.asDiagonal() * Qww * unit.asDiagonal();
    if (!scaled.allFinite()) {
      least_ = -std::numeric_limits<double>::infinity();
      least_knot_ = -1;
      return false;
    }
    const double limit = kPositive * static_cast<double>(Qww.rows());
    shifted_ = scaled;
    shifted_.diagonal().array() -= limit;
    if (factors_.factorize(shifted_, 0)) {
      if (!factors_.factorize(scaled, 0)) return false;
      rhs_.resize(Qww.rows(), Qwx.cols() + kSides);
      rhs_ << -(unit.asDiagonal() * Qwx), -(unit.asDiagonal() * qw);
      factors_.solve(rhs_);
      wx = unit.asDiagonal() * rhs_.leftCols(Qwx.cols());
      w0 = unit.asDiagonal() * rhs_.rightCols(kSides);
      return true;
    }
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled);
    const VectorXd& values = eigen.eigenvalues();
    if (values[0] < least_) {
      least_ = values[0];
      least_knot_ = k;
    }
    if (values[0] < -kNegative) {
      found_ = direction(k, Z * (unit.asDiagonal() * eigen.eigenvectors().col(0)));
      if (found_.gain() > least_gain_) return false;
    }
    for (Index i = 0; i < values.size() && values[i] <= limit; ++i)
      slide(k, Z * (unit.asDiagonal() * eigen.eigenvectors().col(i)),
            eigen.eigenvectors().col(i).dot(unit.asDiagonal() * qw.col(1)));
    // Directions lost to rounding are left unchanged, and no others: controls that stabilize a
    // motion may be weak.
    const VectorXd inverse =
        values.unaryExpr([limit](double v) { return v > limit ? 1 / v : 0.0; });
    const MatrixXd V = unit.asDiagonal() * eigen.eigenvectors();
    const MatrixXd solution = -V * inverse.asDiagonal() * V.transpose();
    wx = solution * Qwx;
    w0 = solution * qw;
    return true;
  }

  /// Gain of controls without curvature, by their slope along the later policy. Gains of the policy
  /// may be huge, so the motion is measured by its own size.
  void slide(int k, const VectorXd& start, double slope) {
    const double largest = start.lpNorm<Eigen::Infinity>();
    if (!(std::abs(slope) > flat_gain_ * largest) || !(std::abs(slope) > least_gain_ * largest))
      return;
    const Descent along = direction(k, start);
    double fall = 0;
    for (std::size_t j = 0; j < nodes_.size(); ++j) fall -= nodes_[j].gradient.dot(along.z[j]);
    const double way = step_length(nodes_, along.z, fall > 0 ? 1 : -1);
    if (std::isfinite(fall)) flat_gain_ = std::max(flat_gain_, way * std::abs(fall));
  }

  const std::vector<ScaledNode>& nodes_;
  const double least_gain_;
  std::vector<Stage> stages_;
  MatrixXd P_, p_, PF_, Q_, transposed_, closed_;
  MatrixXd E_;  ///< bound on the rounding of P, relative to that of one number
  StateRows rows_;
  Eigen::RowVector2d constant_ = Eigen::RowVector2d::Zero();
  double least_ = std::numeric_limits<double>::infinity();
  int least_knot_ = -1;
  SmallCholesky factors_;
  SmallCholesky::Rows rhs_;
  MatrixXd shifted_;
  Descent found_;
  double flat_gain_ = 0;
};

/// Returns the possible share of a step, and holds the rows that stop it.
double limit_step(std::vector<ScaledNode>& nodes, const std::vector<VectorXd>& step) {
  const double length = step_length(nodes, step, 1);
  for (std::size_t k = 0; length < 1 && k < nodes.size(); ++k)
    for (Row& row : nodes[k].rows)
      if (row.role != Row::Role::held && row.way(step[k]) <= std::min(1.0, 2 * length + kNear))
        row.role = Row::Role::held;
  return length;
}

/// Gain predicted by Newton's step on the active rows and those it runs into. Such rows only lower
/// the gain, so the search ends once the gain is negligible compared with the cost.
double attainable_gain(std::vector<ScaledNode> nodes, const Recursion& first, double cost_size) {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  double best = 0;
  const Recursion* found = &first;
  std::vector<std::unique_ptr<Recursion>> kept;
  for (int round = 0; round < kRounds; ++round) {
    const double gain = -found->least_values()[1];
    const double length = limit_step(nodes, found->step());
    best = std::max(best, length * (2 - length) * gain);
    if (length >= 1 || gain <= kLeastGain * cost_size) break;
    kept.push_back(std::make_unique<Recursion>(nodes, kAny));
    if (!kept.back()->run()) break;
    found = kept.back().get();
  }
  return best;
}

/// Nodes with a penalty ½ ρ (aᵀz)² on each held row, which nothing holds any more.
std::vector<ScaledNode> penalized(std::vector<ScaledNode> nodes, double penalty) {
  for (ScaledNode& node : nodes)
    for (Row& row : node.rows)
      if (row.role == Row::Role::held) {
        node.hessian += penalty * row.a * row.a.transpose();
        row = {std::move(row.a)};
      }
  return nodes;
}

/// Smallest bound on the gain of Newton's step by penalties, or infinity if none proves positive
/// curvature. A Hessian that is positive with a penalty is positive along the rows (Debreu 1952),
/// and its step gains no less than the one that keeps the rows. Elimination needs gains
/// that are inverse to its pivots, which are small where rows depend on each other or controls
/// hardly move them; penalties need no pivots.
double penalized_gain(const std::vector<ScaledNode>& nodes, double cost_size) {
  double least = std::numeric_limits<double>::infinity();
  for (const double penalty : kPenalties) {
    const std::vector<ScaledNode> free = penalized(nodes, penalty * cost_size);
    Recursion recursion(free, std::numeric_limits<double>::infinity());
    if (recursion.run() && std::isinf(recursion.least()))
      least = std::min(least, -recursion.least_values()[1]);
  }
  return least;
}

}  // namespace

double SecondOrder::hidden_share() const {
  if (resolution <= negligible || resolution >= cost_size) {
    const double left = std::max(gain, kSlopeShare * slope);
    return left > negligible && left <= resolution ? left / cost_size : 0;
  }
  return resolution / cost_size;
}

double SecondOrder::share() const {
  double left = std::max(gain, kSlopeShare * slope);
  if (left <= resolution) left = 0;
  if (repair > kRepair * resolution) left = std::max(left, repair);
  if (left == 0) return 0;
  return cost_size > 0 ? left / cost_size : std::numeric_limits<double>::infinity();
}

void SecondOrder::scale(double factor) {
  for (const auto& [name, figure] : kSecondOrderFigures) this->*figure *= factor;
  negligible *= factor;
}

namespace {

bool is_decided(const SecondOrder& found) {
  return found.curvature != Curvature::undecided && found.share() <= kLeastGain;
}

SecondOrder judge(const Model& model, const std::vector<ScaledNode>& nodes) {
  SecondOrder out;
  out.cost_size = model.cost_size();
  out.resolution = model.resolution();
  out.negligible = model.negligible();
  out.slope = model.slope();
  const double least_gain = kLeastGain * out.cost_size + out.resolution;
  Recursion recursion(nodes, least_gain);
  const bool bounded = recursion.run();
  out.least = recursion.least();
  out.knot = recursion.least_knot();
  if (bounded) {
    const bool settled = std::isinf(out.least);
    const double bound = settled ? out.least : penalized_gain(nodes, out.cost_size);
    if (settled || bound <= least_gain) {
      out.curvature = Curvature::positive;
      out.least = std::numeric_limits<double>::infinity();
      out.knot = -1;
    }
    out.gain = bound <= least_gain
                   ? bound
                   : attainable_gain(nodes, recursion, out.cost_size) + recursion.flat_gain();
    const auto values = recursion.least_values();
    out.repair = std::abs(values[0] - values[1] + recursion.pressed());
    if (!is_decided(out)) out.amplification = recursion.amplification();
    return out;
  }
  const Descent& descent = recursion.descent();
  if (descent.z.empty()) return out;
  out.curvature = Curvature::negative;
  out.bend = descent.bend * descent.length * descent.length;
  for (std::size_t k = 0; k < descent.z.size(); ++k)
    out.direction.push_back(descent.length *
                            descent.z[k].cwiseProduct(model.unit(static_cast<int>(k))));
  return out;
}

/// True if rows follow from others, or if controls hardly move them: to close a negligible
/// violation takes moves beyond all ranges.
bool is_ill_posed(const SecondOrder& found) { return kNear * found.amplification > 1; }

/// Name of the first equation whose release decides the model; otherwise empty.
std::string doubtful_equation(const ShootingProblem& problem, const Model& model) {
  std::set<std::string_view> tried;
  for (const NodeConstraint& c : problem.constraints()) {
    if (!tried.insert(c.term->name).second) continue;
    std::vector<ScaledNode> nodes = model.nodes();
    bool released = false;
    for (ScaledNode& node : nodes)
      for (Row& row : node.rows)
        if (row.equation != nullptr && row.equation->name == c.term->name) {
          row = {std::move(row.a)};
          released = true;
        }
    if (!released) continue;
    const SecondOrder without = judge(model, nodes);
    if (without.curvature == Curvature::positive && is_decided(without)) return c.term->name;
  }
  return {};
}

}  // namespace

SecondOrder second_order(const JudgedPoint& point) {
  const Model model(point);
  SecondOrder out = judge(model, model.nodes());
  if (!is_decided(out) && is_ill_posed(out)) out.doubtful = doubtful_equation(point.problem, model);
  if (out.curvature == Curvature::positive) out.kink = find_falling_kink(point, out.cost_size);
  if (out.kink) out.curvature = Curvature::undecided;
  return out;
}

}  // namespace conddp
