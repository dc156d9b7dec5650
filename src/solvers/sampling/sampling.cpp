#include "solvers/sampling/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/random_numbers.hpp"
#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

class Search {
 public:
  Search(const ControlSplines& splines, const SamplingOptions& options, const Simulate& simulate)
      : options_(options),
        rollouts_(splines, options.threads, simulate),
        normal_(options.seed),
        mean_(Eigen::VectorXd::Zero(splines.parameters())),
        deviation_(tuning::kNoiseShare * Eigen::Map<const Eigen::VectorXd>(splines.scales().data(),
                                                                           splines.parameters())),
        best_(mean_),
        theta_(splines.parameters(), options.samples),
        values_(options.samples + 1),
        scores_(options.samples + 1),
        sorted_(options.samples + 1),
        order_(options.samples) {
    values_.back().cost = values_.back().violation = std::nan("");
  }

  SampledTrajectory run(const Trajectory& nominal) {
    SampledTrajectory answer{.trajectory = nominal};
    for (int round = 0; round < options_.rounds; ++round) {
      draw();
      rollouts_.evaluate(theta_, values_);
      answer.rollouts += options_.samples;
      for (int i = 0; i < options_.samples; ++i) answer.discarded += !values_[i].finite();
      score(round + 1);
      keep_best();
      if (values_.back().finite()) adapt();
    }
    answer.value = values_.back();
    answer.found = answer.value.finite() && !best_.isZero(0) &&
                   rollouts_.roll_out(best_.data(), answer.trajectory);
    if (!answer.found) answer.trajectory = nominal;
    return answer;
  }

 private:
  /// The first sample is the mean itself.
  void draw() {
    theta_.colwise() = mean_;
    for (int i = 1; i < options_.samples; ++i)
      for (int p = 0; p < mean_.size(); ++p) theta_(p, i) += deviation_[p] * normal_.next();
  }

  /// Median of `part` over the samples whose part passes; 0 without any.
  template <class Part, class Passes>
  double median(Part part, Passes passes) {
    sorted_.clear();
    for (const RolloutValue& value : values_)
      if (value.finite() && passes(part(value))) sorted_.push_back(part(value));
    if (sorted_.empty()) return 0;
    const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
    std::ranges::nth_element(sorted_, middle);
    return *middle;
  }

  /// Sets all scores; penalties grow from round to round.
  void score(int round) {
    const double rate = tuning::kPenaltyRate * round, weight = std::max(1.0, rate * rate);
    const auto ratio = [](double part, double whole) { return whole > 0 ? part / whole : 0.0; };
    double least = std::numeric_limits<double>::infinity();
    for (const RolloutValue& value : values_)
      if (value.finite()) least = std::min(least, value.cost);
    const double cost =
        median([](const RolloutValue& value) { return value.cost; }, [](double) { return true; }) -
        least;
    const double violation = median([](const RolloutValue& value) { return value.violation; },
                                    [](double part) { return part > 0; });
    for (std::size_t i = 0; i < values_.size(); ++i)
      scores_[i] = values_[i].finite() ? ratio(values_[i].cost - least, cost) +
                                             weight * ratio(values_[i].violation, violation)
                                       : std::numeric_limits<double>::infinity();
  }

  /// Keeps the best sample so far, with its value behind those of the round.
  void keep_best() {
    const auto best = std::min_element(scores_.begin(), scores_.end() - 1);
    if (!(*best < scores_.back())) return;
    const auto index = best - scores_.begin();
    best_ = theta_.col(index);
    values_.back() = values_[index];
    scores_.back() = *best;
  }

  void adapt() {
    switch (options_.method) {
      case SamplingMethod::predictive:
        mean_ = best_;
        break;
      case SamplingMethod::cem:
        fit_elites();
        break;
      case SamplingMethod::mppi:
        weigh();
        break;
    }
  }

  void fit_elites() {
    const int elites = std::max(1, static_cast<int>(tuning::kEliteShare * options_.samples));
    std::iota(order_.begin(), order_.end(), 0);
    std::ranges::sort(order_, {}, [&](int i) { return std::pair(scores_[i], i); });
    mean_.setZero();
    for (int e = 0; e < elites; ++e) mean_ += theta_.col(order_[e]);
    mean_ /= elites;
    deviation_.setZero();
    for (int e = 0; e < elites; ++e) deviation_ += (theta_.col(order_[e]) - mean_).cwiseAbs2();
    deviation_ = (deviation_ / elites).cwiseSqrt();
  }

  void weigh() {
    const double least = *std::min_element(scores_.begin(), scores_.end() - 1);
    if (!std::isfinite(least)) return;
    mean_.setZero();
    double sum = 0;
    for (int i = 0; i < options_.samples; ++i) {
      const double weight = std::exp(-tuning::kPathSharpness * (scores_[i] - least));
      mean_ += weight * theta_.col(i);
      sum += weight;
    }
    mean_ /= sum;
  }

  const SamplingOptions& options_;
  RolloutValues rollouts_;
  NormalNumbers normal_;
  Eigen::VectorXd mean_, deviation_, best_;
  Eigen::MatrixXd theta_;             ///< parameters x samples
  std::vector<RolloutValue> values_;  ///< of the samples, then of the best one so far
  std::vector<double> scores_;        ///< likewise
  std::vector<double> sorted_;
  std::vector<int> order_;
};

}  // namespace

SampledTrajectory search_controls(const ControlSplines& splines, const SamplingOptions& options,
                                  const Simulate& simulate) {
  return Search(splines, options, simulate).run(splines.nominal());
}

}  // namespace conddp
