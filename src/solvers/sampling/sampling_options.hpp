#pragma once

#include <cstdint>

namespace conddp {

/// How the distribution of the parameters changes from round to round:
/// - predictive: noise of constant size around the best sample so far (Howell et al. 2022);
/// - cem: mean and standard deviation of the best tenth (de Boer et al. 2005);
/// - mppi: mean with exponential weights, noise of constant size (Theodorou et al. 2010).
enum class SamplingMethod { predictive, cem, mppi };

struct SamplingOptions {
  SamplingMethod method = SamplingMethod::predictive;
  int samples = 128;  ///< per round
  int rounds = 50;
  std::uint64_t seed = 1;
  int threads = 1;
};

}  // namespace conddp
