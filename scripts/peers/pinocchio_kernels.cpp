// pinocchio_kernels URDF fixed|floating: microseconds a call of Pinocchio's algorithms, the median
// of 25 batches, each over random states.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/parsers/urdf.hpp>

using Eigen::VectorXd;

namespace {

constexpr int kStates = 64, kBatches = 25, kWarmUp = 5;

struct State {
  VectorXd q, v, a;
};

template <class Work>
void print_time(const char* name, const std::vector<State>& states, const Work& work) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times;
  for (int batch = -kWarmUp; batch < kBatches; ++batch) {
    const auto began = Clock::now();
    for (int round = 0; round < 8; ++round)
      for (const State& state : states) work(state);
    const std::chrono::duration<double, std::micro> took = Clock::now() - began;
    if (batch >= 0) times.push_back(took.count() / (8 * kStates));
  }
  std::nth_element(times.begin(), times.begin() + kBatches / 2, times.end());
  std::printf("%s %.4f\n", name, times[kBatches / 2]);
}

}  // namespace

int main(int, char** argv) {
  pinocchio::Model model;
  if (std::string(argv[2]) == "floating") {
    pinocchio::urdf::buildModel(argv[1], pinocchio::JointModelFreeFlyer(), model);
  } else {
    pinocchio::urdf::buildModel(argv[1], model);
  }
  pinocchio::Data data(model);
  std::srand(1);
  const VectorXd limit = VectorXd::Constant(model.nq, 1.0);
  std::vector<State> states;
  for (int i = 0; i < kStates; ++i)
    states.push_back({pinocchio::randomConfiguration(model, -limit, limit),
                      VectorXd::Random(model.nv), VectorXd::Random(model.nv)});
  print_time("rnea", states, [&](const State& s) { rnea(model, data, s.q, s.v, s.a); });
  print_time("crba", states,
             [&](const State& s) { crba(model, data, s.q, pinocchio::Convention::LOCAL); });
  // Computes M as well.
  print_time("rnea_derivatives", states,
             [&](const State& s) { computeRNEADerivatives(model, data, s.q, s.v, s.a); });
  print_time("aba_derivatives", states,
             [&](const State& s) { computeABADerivatives(model, data, s.q, s.v, s.a); });
}
