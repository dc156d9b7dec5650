#include "analysis/contact/contact_pairs.hpp"

namespace conddp {

ContactPairs::ContactPairs(int count, int nv)
    : value(Eigen::VectorXd::Zero(count)),
      slope(Eigen::MatrixXd::Zero(count, nv)),
      push(Eigen::MatrixXd::Zero(count, nv)),
      coupling(Eigen::MatrixXd::Zero(count, count)),
      budget(count, false) {}

int ContactPairs::add(double w, const Eigen::RowVectorXd& w_slope,
                      const Eigen::RowVectorXd& impulse) {
  value[filled_] = w;
  slope.row(filled_) = w_slope;
  push.row(filled_) = impulse;
  return filled_++;
}

void ContactPairs::add_friction(const Eigen::MatrixXd& tangents, const Eigen::MatrixXd& slopes,
                                const Eigen::VectorXd& v, const Budget& available) {
  const int first = filled_, slack = filled_ + 2 * static_cast<int>(tangents.rows());
  for (int t = 0; t < tangents.rows(); ++t)
    for (const double sign : {1.0, -1.0}) {
      const int edge =
          add(sign * tangents.row(t).dot(v), sign * slopes.row(t), sign * tangents.row(t));
      coupling(edge, slack) = 1;
    }
  value[slack] = available.constant;
  budget[slack] = true;
  if (available.normal >= 0) coupling(slack, available.normal) = available.factor;
  coupling.row(slack).segment(first, slack - first).setConstant(-1);
  ++filled_;
}

void ContactPairs::rest(int count) {
  value.segment(filled_, count).setOnes();
  filled_ += count;
}

std::optional<int> ContactPairs::slowest_edge(int of, const Eigen::VectorXd& w) const {
  std::optional<int> slowest;
  for (int i = 0; i < w.size(); ++i)
    if (coupling(i, of) == 1 && (!slowest || w[i] < w[*slowest])) slowest = i;
  return slowest;
}

}  // namespace conddp
