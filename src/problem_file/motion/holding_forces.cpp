#include "problem_file/motion/holding_forces.hpp"

#include <algorithm>

#include <Eigen/Dense>

#include "ocp/residuals/stepping_residual.hpp"

namespace conddp {
namespace {

/// ρ over the largest entry of GᵀG: just large enough to make the forces unique.
constexpr double kSmall = 1e-8;

/// Cancels the common part of opposite friction directions, which has no effect.
void cancel_opposites(const FrictionIndices& f, Eigen::Ref<Eigen::VectorXd> w) {
  for (int i = 0; i < f.count; i += 2) {
    const double common = std::min(w[f.force[i]], w[f.force[i + 1]]);
    w[f.force[i]] -= common;
    w[f.force[i + 1]] -= common;
  }
}

/// The edges of a candidate's pyramid: entries of w with their change per normal force.
std::vector<std::pair<int, double>> edges_of(const SteppingLayout::Candidate& at, double friction) {
  std::vector<std::pair<int, double>> edges;
  for (int i = 0; i < at.friction.count; ++i) edges.emplace_back(at.friction.force[i], friction);
  for (int i = 0; at.cone.present && i < 2; ++i)
    for (const double sign : {1.0, -1.0}) edges.emplace_back(at.cone.force[i], sign * friction);
  if (edges.empty()) edges.emplace_back(at.force, 0);
  return edges;
}

}  // namespace

HoldingForces::HoldingForces(const std::shared_ptr<const SteppingSystem>& system, int ndx,
                             double product)
    : system_(system),
      equations_(stepping_residual(system, ndx)),
      row_names_(stepping_row_names(*system)),
      data_(system->create_data(double{})),
      product_(product),
      column_(system->nu(), -1),
      qp_(system->nu()) {
  const std::vector<int>& columns = equations_->blocks().front().columns;
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c] >= ndx) column_[columns[c] - ndx] = static_cast<int>(c);
  for (int i = 0; i < system->layout().actuators; ++i)
    unknowns_.push_back({.entries = {{i, 1}}, .lower = -kUnlimited});
  add_candidates();
  add_joints();
}

int HoldingForces::row(const std::string& name) const {
  return static_cast<int>(std::find(row_names_.begin(), row_names_.end(), name) -
                          row_names_.begin());
}

void HoldingForces::add_candidates() {
  const SteppingLayout& layout = system_->layout();
  for (std::size_t c = 0; c < layout.candidates.size(); ++c) {
    const SteppingLayout::Candidate& at = layout.candidates[c];
    const ContactCandidate& candidate = system_->contacts().candidates[c];
    const auto edges = edges_of(at, candidate.friction);
    const int gap = row("contact/" + candidate.name + "/gap");
    for (const auto& edge : edges)
      unknowns_.push_back({.entries = {{at.force, 1}, edge},
                           .distance_row = gap,
                           .share = static_cast<int>(edges.size())});
  }
}

void HoldingForces::add_joints() {
  const SteppingLayout& layout = system_->layout();
  for (const SteppingLayout::Stop& stop : layout.stops)
    unknowns_.push_back(
        {.entries = {{stop.force, 1}},
         .distance_row = row("stop/" + system_->multibody().robot().joints[stop.joint].name +
                             (stop.upper ? "/upper" : "/lower"))});
  for (std::size_t i = 0; i < layout.frictions.size(); ++i)
    for (int k = 0; k < 2; ++k)
      unknowns_.push_back({.entries = {{layout.frictions[i].force[k], 1}},
                           .upper = system_->contacts().frictions[i].limit});
}

double HoldingForces::find(const double* x, double h, const std::vector<double>& lower,
                           const std::vector<double>& upper, Eigen::Ref<Eigen::VectorXd> w) {
  const SteppingLayout& layout = system_->layout();
  const int n = layout.nv, count = static_cast<int>(unknowns_.size());
  Eigen::VectorXd still = Eigen::VectorXd::Zero(w.size());
  still.segment(layout.acceleration, n) = w.segment(layout.acceleration, n);
  std::vector<double> rows(equations_->size()), slopes(equations_->jacobian_size());
  equations_->differentiate({x, still.data(), &h, *data_}, rows.data(), slopes.data());
  const Eigen::Map<const Eigen::VectorXd> load(rows.data(), n);
  const Eigen::Map<const Eigen::MatrixXd> motion(
      slopes.data(), n, static_cast<Eigen::Index>(equations_->blocks().front().columns.size()));

  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n, count);
  Eigen::VectorXd low(count), high(count);
  for (int j = 0; j < count; ++j) {
    const Unknown& unknown = unknowns_[j];
    for (const auto& [entry, factor] : unknown.entries)
      G.col(j) += factor * motion.col(column_[entry]);
    low[j] = j < layout.actuators ? lower[j] : unknown.lower;
    high[j] = j < layout.actuators ? upper[j] : unknown.upper;
    if (unknown.distance_row < 0) continue;
    const double distance = -rows[unknown.distance_row] * unknown.share;
    if (distance > 0) high[j] = product_ / distance;
  }
  const Eigen::VectorXd y = smallest(G, load, low, high);
  write(y, w);
  return (load + G * y).lpNorm<Eigen::Infinity>();
}

Eigen::VectorXd HoldingForces::smallest(const Eigen::MatrixXd& G,
                                        const Eigen::Ref<const Eigen::VectorXd>& load,
                                        const Eigen::VectorXd& lower,
                                        const Eigen::VectorXd& upper) {
  const Eigen::Index count = G.cols();
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(count);
  if (count == 0 || !load.allFinite()) return none;
  Eigen::MatrixXd H = G.transpose() * G;
  H.diagonal().array() += kSmall * H.diagonal().maxCoeff();
  std::vector<BoundState> active(count, BoundState::free);
  const BoxQp::Status status = qp_.solve(H, G.transpose() * load, lower, upper, active);
  return status == BoxQp::Status::not_positive_definite ? none : Eigen::VectorXd(qp_.x());
}

void HoldingForces::write(const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> w) const {
  const SteppingLayout& layout = system_->layout();
  for (const Unknown& unknown : unknowns_)
    for (const auto& [entry, factor] : unknown.entries) w[entry] = 0;
  for (std::size_t j = 0; j < unknowns_.size(); ++j)
    for (const auto& [entry, factor] : unknowns_[j].entries) w[entry] += factor * y[j];
  for (const SteppingLayout::Candidate& at : layout.candidates) cancel_opposites(at.friction, w);
  for (const FrictionIndices& f : layout.frictions) cancel_opposites(f, w);
}

}  // namespace conddp
