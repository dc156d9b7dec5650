// Expression systems compared with compiled ones: values and Jacobians of one point per lane.
#include <memory>

#include <benchmark/benchmark.h>

#include "support/expression_systems.hpp"
#include "support/random_numbers.hpp"

namespace conddp {
namespace {

struct LanePoint {
  explicit LanePoint(const System& system)
      : x(system.nx()), step(system.ndx()), u(system.nu()), data(system.create_data(Lane{})) {
    RandomNumbers random(71);
    for (int i = 0; i < system.nx(); ++i) x[i] = Lane(system.manifold().neutral()[i]);
    const auto fill = [&](AlignedVector<Lane>& numbers) {
      for (Lane& a : numbers)
        for (int i = 0; i < kLaneWidth; ++i) a.set(i, random.uniform(-1, 1));
    };
    fill(step);
    fill(u);
    system.manifold().integrate(x.data(), step.data(), x.data());
  }
  AlignedVector<Lane> x, step, u;
  std::unique_ptr<SystemData<Lane>> data;
};

void add_system(const std::string& name, const std::shared_ptr<const System>& system) {
  benchmark::RegisterBenchmark((name + "/values").c_str(), [system](benchmark::State& state) {
    LanePoint point(*system);
    for (auto _ : state) {
      system->evaluate(point.x.data(), point.u.data(), *point.data);
      benchmark::ClobberMemory();
    }
  });
  benchmark::RegisterBenchmark((name + "/jacobians").c_str(), [system](benchmark::State& state) {
    LanePoint point(*system);
    for (auto _ : state) {
      system->differentiate(point.x.data(), point.u.data(), *point.data);
      benchmark::ClobberMemory();
    }
  });
}

const bool kRegistered = [] {
  for (const SystemInWords& system : systems_in_words()) {
    add_system(system.name + "/compiled", system.compiled);
    add_system(system.name + "/expressions", expression_system(system.text));
  }
  return true;
}();

}  // namespace
}  // namespace conddp
