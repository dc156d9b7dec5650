#include "problem_file/model/node_time.hpp"

#include <algorithm>

#include "problem_file/model/phase_grid.hpp"

namespace conddp {
namespace {

/// Elapsed time of a phase at the beginning of each of its knots.
class PhaseProgress {
 public:
  explicit PhaseProgress(const PhaseSpec& phase) {
    const std::vector<double> steps = phase_steps(phase);
    for (const double step : steps) {
      elapsed_.push_back(whole_);
      whole_ += phase.takes_no_time() ? 0 : step;
    }
  }

  double whole() const { return whole_; }
  const std::vector<double>& elapsed() const { return elapsed_; }

 private:
  std::vector<double> elapsed_;  ///< s, before each knot
  double whole_ = 0;
};

/// Computes the node times of a problem in order.
class NodeTimes {
 public:
  NodeTimes(const ProblemSpec& spec, const std::vector<double>& written)
      : spec_(spec), written_(written) {
    for (const PhaseSpec& phase : spec.phases) durations_ += phase.free_duration ? 1 : 0;
    begin_.share.assign(durations_, 0.0);
    begin_.phase_share.assign(durations_, 0.0);
  }

  std::vector<NodeTime> make(double start) {
    std::size_t duration = 0;
    for (const PhaseSpec& phase : spec_.phases) {
      const PhaseProgress progress(phase);
      const bool free = phase.free_duration.has_value();
      for (const double elapsed : progress.elapsed()) add(progress, elapsed, free, duration);
      if (!phase.takes_no_time()) last_ = Last{progress, free, duration};
      pass(progress, free, duration);
      if (free) ++duration;
    }
    add_last();
    for (NodeTime& node : nodes_)
      node.final_time = start + (durations_ > 0 ? begin_.time : written_.back());
    return std::move(nodes_);
  }

 private:
  struct Last {
    PhaseProgress progress;
    bool free;
    std::size_t duration;
  };

  /// Adds a node at the elapsed time of a phase.
  void add(const PhaseProgress& progress, double elapsed, bool free, std::size_t duration) {
    NodeTime node = begin_;
    const std::size_t k = nodes_.size();
    node.written = written_[k];
    if (free) {
      node.share[duration] = node.phase_share[duration] = elapsed / progress.whole();
    } else {
      node.time += elapsed;
      node.phase_time = elapsed;
    }
    if (durations_ == 0) node.time = written_[k];  // without rounding of sums
    nodes_.push_back(std::move(node));
  }

  void pass(const PhaseProgress& progress, bool free, std::size_t duration) {
    if (free)
      begin_.share[duration] = 1;
    else
      begin_.time += progress.whole();
  }

  void add_last() {
    NodeTime node = begin_;
    node.written = written_.back();
    if (durations_ == 0) node.time = node.written;
    if (last_ && last_->free) node.phase_share[last_->duration] = 1;
    if (last_ && !last_->free) node.phase_time = last_->progress.whole();
    nodes_.push_back(std::move(node));
  }

  const ProblemSpec& spec_;
  const std::vector<double>& written_;
  std::size_t durations_ = 0;  ///< number of free durations
  NodeTime begin_;             ///< start of the next phase
  std::optional<Last> last_;   ///< last phase that took time
  std::vector<NodeTime> nodes_;
};

}  // namespace

void NodeTime::append_to(std::vector<double>& parameters) const {
  parameters.insert(parameters.end(), {time, phase_time, final_time});
  parameters.insert(parameters.end(), share.begin(), share.end());
  parameters.insert(parameters.end(), phase_share.begin(), phase_share.end());
}

NodeTime time_within(const NodeTime& knot, double step, double passed, const ProblemSpec& spec,
                     std::size_t phase) {
  NodeTime time = knot;
  const double elapsed = passed * step;
  time.written += elapsed;
  if (!spec.phases[phase].free_duration) {
    time.time += elapsed;
    time.phase_time += elapsed;
    return time;
  }
  const auto duration =
      std::count_if(spec.phases.begin(), spec.phases.begin() + static_cast<std::ptrdiff_t>(phase),
                    [](const PhaseSpec& other) { return other.free_duration.has_value(); });
  const double share = elapsed / phase_duration(spec.phases[phase]);
  time.share[duration] += share;
  time.phase_share[duration] += share;
  return time;
}

std::vector<NodeTime> node_times(const ProblemSpec& spec, const std::vector<double>& written,
                                 double start) {
  return NodeTimes(spec, written).make(start);
}

}  // namespace conddp
