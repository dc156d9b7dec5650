#pragma once

#include <map>
#include <memory>
#include <vector>

#include "ocp/evaluation/lane_transfer.hpp"
#include "ocp/knot/knot_batch.hpp"
#include "ocp/knot/knot_second_derivatives.hpp"

namespace conddp {

/// The workspaces of evaluators, by model. Evaluators of problems with common models may share
/// them, as long as only one of these evaluates at a time.
class EvaluationMemory {
 public:
  /// What evaluations of one model need.
  struct OfModel {
    OfModel(std::shared_ptr<const KnotModel> knot_model, int threads);

    std::shared_ptr<const KnotModel> model;
    LaneScatter hessian, lasting_hessian, constraint;     ///< where derivatives can be non-zero
    std::vector<std::unique_ptr<KnotBatch<Lane>>> lanes;  ///< by thread, as the next two
    /// From reserve_second_derivatives() on.
    std::vector<std::unique_ptr<KnotBatch<Dual<Lane>>>> duals;
    std::vector<std::unique_ptr<KnotSecondDerivatives>> seconds;  ///< null: the model has none
    KnotBatch<double> single;                                     ///< of rollouts

    /// The first call decides whether Hessians are put together of parts.
    void reserve_second_derivatives(bool by_parts);
  };

  /// For evaluators of so many threads, as far as the process gets them.
  explicit EvaluationMemory(int threads);

  int threads() const { return threads_; }
  /// Allocates at the first call with a model. It stays where it is.
  OfModel& of(const std::shared_ptr<const KnotModel>& model);

 private:
  int threads_;
  std::map<const KnotModel*, std::unique_ptr<OfModel>> models_;
};

}  // namespace conddp
