#include "ocp/evaluation/evaluation_memory.hpp"

#include <utility>

namespace conddp {
namespace {

/// Hessian entries that the costs always fill.
std::vector<std::pair<int, int>> lasting_pattern(const KnotModel& model) {
  const auto& pattern = model.hessian_pattern();
  return {pattern.begin(), pattern.begin() + model.lasting_entries()};
}

}  // namespace

EvaluationMemory::OfModel::OfModel(std::shared_ptr<const KnotModel> knot_model, int threads)
    : model(std::move(knot_model)),
      hessian(LaneScatter::symmetric(model->hessian_pattern(), model->nz())),
      lasting_hessian(LaneScatter::symmetric(lasting_pattern(*model), model->nz())),
      constraint(
          LaneScatter::matrix(model->constraint_pattern(), model->constraint_rows(), model->nz())),
      single(*model) {
  for (int t = 0; t < threads; ++t) lanes.push_back(std::make_unique<KnotBatch<Lane>>(*model));
}

void EvaluationMemory::OfModel::reserve_second_derivatives(bool by_parts) {
  if (!duals.empty()) return;
  for (const auto& at : lanes) {
    duals.push_back(std::make_unique<KnotBatch<Dual<Lane>>>(*model));
    seconds.push_back(by_parts ? KnotSecondDerivatives::make(*model, *at, *duals.back()) : nullptr);
  }
}

EvaluationMemory::EvaluationMemory(int threads) : threads_(usable_threads(threads)) {}

EvaluationMemory::OfModel& EvaluationMemory::of(const std::shared_ptr<const KnotModel>& model) {
  std::unique_ptr<OfModel>& found = models_[model.get()];
  if (found == nullptr) found = std::make_unique<OfModel>(model, threads_);
  return *found;
}

}  // namespace conddp
