#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

#include <tbb/global_control.h>

#include "ocp/evaluation/lane_transfer.hpp"
#include "ocp/knot/knot_model.hpp"
#include "ocp/knot/knot_second_derivatives.hpp"

namespace conddp {

/// Evaluator workspaces by model. Evaluators of problems with common models may share them if only
/// one evaluates at a time.
class EvaluationMemory {
 public:
  /// Workspaces of one model.
  struct OfModel {
    OfModel(std::shared_ptr<const KnotModel> knot_model, int threads);

    std::shared_ptr<const KnotModel> model;
    LaneScatter hessian, lasting_hessian, constraint;     ///< entries that can be nonzero
    std::vector<std::unique_ptr<KnotBatch<Lane>>> lanes;  ///< per thread, as are the next two
    /// Filled by reserve_second_derivatives().
    std::vector<std::unique_ptr<KnotBatch<Dual<Lane>>>> duals;
    std::vector<std::unique_ptr<KnotSecondDerivatives>> seconds;  ///< null: unsupported
    KnotBatch<double> single;                                     ///< for rollouts

    /// The first call decides whether Hessians are assembled from parts.
    void reserve_second_derivatives(bool by_parts);
  };

  /// For evaluators with this many threads, limited to those that the process gets.
  explicit EvaluationMemory(int threads);

  int threads() const { return threads_; }
  /// Allocates on the first call with a model. The reference remains valid.
  OfModel& of(const std::shared_ptr<const KnotModel>& model);

 private:
  int threads_;
  std::map<const KnotModel*, std::unique_ptr<OfModel>> models_;
};

/// Number of threads, at most `wanted` and at least 1, that this process gets from TBB. An arena
/// for more threads would gain nothing, and TBB would print a warning on stderr.
inline int usable_threads(int wanted) {
  using tbb::global_control;
  const auto most = global_control::active_value(global_control::max_allowed_parallelism);
  return std::clamp(wanted, 1, std::max(1, static_cast<int>(most)));
}

}  // namespace conddp
