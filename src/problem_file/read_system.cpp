#include <fmt/format.h>

#include "problem_file/read_sections.hpp"

namespace conddp {
namespace {

std::optional<Eigen::MatrixXd> read_matrix(const YamlReader& reader) {
  const auto rows = reader.items();
  if (!rows) return std::nullopt;
  Eigen::MatrixXd matrix;
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const auto row = (*rows)[i].numbers();
    if (!row) return std::nullopt;
    if (i == 0) matrix.resize(rows->size(), row->size());
    if (static_cast<Eigen::Index>(row->size()) != matrix.cols()) {
      (*rows)[i].error(
          fmt::format("this row has {} numbers, the first one has {}", row->size(), matrix.cols()));
      return std::nullopt;
    }
    for (std::size_t j = 0; j < row->size(); ++j) matrix(i, j) = (*row)[j];
  }
  if (matrix.size() == 0) return reader.error("the matrix is empty"), std::nullopt;
  return matrix;
}

void read(YamlMap& map, DoubleIntegratorSpec& p) { map.integer("dimension", p.dimension, 1, 1000); }

void read(YamlMap& map, LinearSpec& p) {
  const auto A = map.require("A");
  const auto B = map.require("B");
  const auto c = map.find("c");
  if (!A || !B) return;
  const auto a = read_matrix(*A);
  const auto b = read_matrix(*B);
  if (!a || !b) return;
  if (a->rows() != a->cols())
    return A->error(fmt::format("A is {} x {}, not square", a->rows(), a->cols()));
  if (b->rows() != a->rows())
    return B->error(fmt::format("B has {} rows and A has {}", b->rows(), a->rows()));
  p.A = *a;
  p.B = *b;
  p.c = Eigen::VectorXd::Zero(a->rows());
  if (c)
    if (const auto n = c->numbers(a->rows(), "one a row of A"))
      p.c = Eigen::Map<const Eigen::VectorXd>(n->data(), n->size());
}

void read(YamlMap& map, PendulumParameters& p) {
  map.number("mass", p.mass, kPositive);
  map.number("length", p.length, kPositive);
  map.number("inertia", p.inertia, kPositive);
  map.number("damping", p.damping, kNotNegative);
  map.number("gravity", p.gravity);
}

void read(YamlMap& map, CartpoleParameters& p) {
  map.number("cart_mass", p.cart_mass, kPositive);
  map.number("pole_mass", p.pole_mass, kPositive);
  map.number("length", p.length, kPositive);
  map.number("gravity", p.gravity);
}

void read(YamlMap& map, AcrobotParameters& p) {
  map.number("length1", p.length1, kPositive);
  map.number("length2", p.length2, kPositive);
  map.number("mass1", p.mass1, kPositive);
  map.number("mass2", p.mass2, kPositive);
  map.number("inertia1", p.inertia1, kPositive);
  map.number("inertia2", p.inertia2, kPositive);
  map.number("friction", p.friction, kNotNegative);
  map.number("gravity", p.gravity);
}

void read(YamlMap&, UnicycleSpec&) {}

void read(YamlMap& map, CarSpec& p) { map.number("wheelbase", p.wheelbase, kPositive); }

void read(YamlMap& map, PlanarQuadrotorParameters& p) {
  map.number("mass", p.mass, kPositive);
  map.number("inertia", p.inertia, kPositive);
  map.number("arm", p.arm, kPositive);
  map.number("gravity", p.gravity);
}

void read(YamlMap& map, QuadrotorParameters& p) {
  map.number("mass", p.mass, kPositive);
  map.number("jx", p.jx, kPositive);
  map.number("jy", p.jy, kPositive);
  map.number("jz", p.jz, kPositive);
  map.number("arm", p.arm, kPositive);
  map.number("torque_ratio", p.torque_ratio, kPositive);
  map.number("gravity", p.gravity);
}

using Parameters = decltype(SystemSpec::parameters);

template <class P>
Parameters read_as(YamlMap& map) {
  P parameters;
  read(map, parameters);
  return parameters;
}

struct SystemType {
  std::string_view name;
  Parameters (*read)(YamlMap&);
};

constexpr SystemType kTypes[] = {
    {"double_integrator", read_as<DoubleIntegratorSpec>},
    {"linear", read_as<LinearSpec>},
    {"pendulum", read_as<PendulumParameters>},
    {"cartpole", read_as<CartpoleParameters>},
    {"acrobot", read_as<AcrobotParameters>},
    {"unicycle", read_as<UnicycleSpec>},
    {"car", read_as<CarSpec>},
    {"planar_quadrotor", read_as<PlanarQuadrotorParameters>},
    {"quadrotor", read_as<QuadrotorParameters>},
};

}  // namespace

SystemSpec read_system(const YamlReader& reader) {
  SystemSpec system{.place = reader.place()};
  YamlMap map(reader);
  const auto type = map.require("type");
  std::vector<std::string> words;
  for (const SystemType& entry : kTypes) words.emplace_back(entry.name);
  const auto index = type ? type->choose(words, "type of system") : std::nullopt;
  if (index)
    system.parameters = kTypes[*index].read(map);
  else
    map.ignore_others();
  return system;
}

}  // namespace conddp
